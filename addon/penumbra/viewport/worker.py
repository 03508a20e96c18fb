"""A thread with a renderer that answers the newest question of one viewport, so that Blender never waits for a picture.

Blender asks (`ask`) and draws the newest answer there is (`shown`). A newer question ends the work on an older one.
Knows neither `gpu` nor Blender's data.
"""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from .. import errors, native, picture
from ..progress import ToldProgress

PATIENCE_S = 0.5
"""While a view turns, a newer question comes with every drawing. A first answer to an older one is made all the same if
it takes no longer than this: else nothing would be seen before the hand rests."""

_MOST_KEPT_BYTES = 32 << 20
"""Of earlier frames. A view that turns asks for none of them again, and each viewport has a renderer of its own; what
comes back is the same view after another light or a colour changed."""

_LONGEST_WAIT_S = 2.0  # for the thread at the end
_LONGEST_WAIT_AT_EXIT_S = 60.0  # a core at work hears within a second or a few that nobody waits for it any more

_open: weakref.WeakSet[Worker[Any]] = weakref.WeakSet()

A = TypeVar("A")


class Desk(Generic[A]):
    """What the work on one question has to do with the one who asked."""

    def __init__(self, worker: Worker[A], question: Question[A]) -> None:
        self._worker = worker
        self._question = question

    def stop_if_old(self) -> None:
        """@raises picture.StoppedError when nobody waits for this any more"""
        self._worker.stop_if_old(self._question)

    def progress(self) -> ToldProgress:
        """For the core's long calls: they end when nobody waits for them any more."""
        return ToldProgress(lambda _share, _text: self.stop_if_old())

    def show(self, answer: A) -> None:
        """Hands an answer on; there may be several, each better than the one before."""
        self._worker.show(self._question, answer)


@dataclass(frozen=True, eq=False)
class Question(Generic[A]):
    key: Hashable  # equal keys mean equal answers
    work: Callable[[Any, Desk[A]], None]  # (core.Renderer, desk), on the worker's thread
    device: str = ""
    view_by: str = ""


class Worker(Generic[A]):
    """One viewport's thread and its newest answer."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._question: Question[A] | None = None
        self._shown: A | None = None
        self._problem = ""
        self._version = 0
        self._closed = False
        self._done: Question[A] | None = None
        self._began = 0.0  # with the question that is worked on
        self._answered = False  # it has a first answer
        self._thread: threading.Thread | None = None
        _open.add(self)

    # ------------------------------------------------------------------------------------ called by Blender's thread

    def ask(self, question: Question[A]) -> None:
        """An answer is wanted; whatever was asked before no longer is."""
        with self._changed:
            if self._closed:
                return
            self._question = question
            self._changed.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="Penumbra viewport", daemon=True)
                self._thread.start()

    @property
    def busy(self) -> bool:
        """There is an unanswered question."""
        with self._changed:
            return not self._closed and self._question is not None and self._question is not self._done

    @property
    def version(self) -> int:
        """Grows with every answer and every problem."""
        with self._changed:
            return self._version

    @property
    def shown(self) -> A | None:
        with self._changed:
            return self._shown

    @property
    def problem(self) -> str:
        """Why there is no newer answer, in one sentence; empty if nothing is wrong."""
        with self._changed:
            return self._problem

    def tell_problem(self, problem: str) -> None:
        """Of Blender's own side: a scene that cannot be read."""
        with self._changed:
            self._problem = problem
            self._version += 1

    def close(self, longest_wait_s: float = _LONGEST_WAIT_S) -> None:
        """Ends the thread and gives its renderer back; never raises, waits two seconds at most."""
        with self._changed:
            self._closed = True
            self._question = self._shown = None
            self._changed.notify()
        if self._thread is not None:
            self._thread.join(longest_wait_s)

    # -------------------------------------------------------------------------------------------------- the thread

    def _run(self) -> None:
        renderer, machine = None, ("", "")
        while True:
            with self._changed:
                while not self._closed and (self._question is None or self._question is self._done):
                    self._changed.wait()
                if self._closed:
                    return
                question = self._question
                self._began, self._answered = time.monotonic(), False
            assert question is not None
            try:
                wanted = (question.device, question.view_by)
                if renderer is None or machine != wanted:
                    renderer = None
                    renderer = native.renderer(native.load(), *wanted, most_kept_bytes=_MOST_KEPT_BYTES)
                    machine = wanted
                question.work(renderer, Desk(self, question))
            except picture.StoppedError:
                continue
            except Exception as error:
                renderer = None  # after an error nobody trusts it
                self._tell(errors.sentence_of(error))
            with self._changed:
                self._done = question

    def stop_if_old(self, question: Question[A]) -> None:
        with self._changed:
            self._check(question)

    def show(self, question: Question[A], answer: A) -> None:
        with self._changed:
            self._check(question)
            self._shown = answer
            self._answered = True
            self._problem = ""
            self._version += 1

    def _check(self, question: Question[A]) -> None:
        """@raises picture.StoppedError"""
        waiting = not self._answered and time.monotonic() - self._began < PATIENCE_S
        if self._closed or (self._question is not question and not waiting):
            raise picture.StoppedError

    def _tell(self, problem: str) -> None:
        with self._changed:
            if self._closed:
                return
            self._problem = problem
            self._version += 1


def unregister() -> None:
    """Closes all there are: Blender as a module waits for ever at its end for a thread that holds a renderer."""
    for worker in list(_open):
        worker.close(_LONGEST_WAIT_AT_EXIT_S)
