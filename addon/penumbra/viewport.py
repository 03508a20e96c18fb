"""Pictures for a 3D viewport, made on a thread of their own, so that Blender never waits for them.

Blender asks for a picture of what it shows (`ask`) and draws the newest that is there (`shown`). While something moves,
a smaller picture comes first; when it rests, the full one follows, and then pixel sample after pixel sample. A newer
question ends the work on an older one. Knows neither `gpu` nor Blender's data: viewport_draw.py puts the pixels up.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import errors, native, passes, picture
from .progress import ToldProgress
from .records import Image

if TYPE_CHECKING:
    from .bridge import SceneExport

LARGEST_HALF = 65504.0
"""Blender keeps viewport pixels as half floats; what is larger would become infinite, and infinite becomes black."""

_SWIFT_S = 0.06  # a full picture that takes no longer needs no small one before it
_LONGEST_WAIT_S = 2.0  # for the thread at the end


@dataclass(frozen=True)
class Question:
    """What a viewport wants to see."""

    key: Hashable  # equal keys mean equal pictures
    export: SceneExport  # its scene belongs to the question: nobody else may change it
    camera: Callable[[tuple[int, int]], Any]  # size in pixels -> core.Camera
    size: tuple[int, int]
    wanted: picture.Wanted
    smaller: int = 2  # divides the size while something moves
    device: str = ""


@dataclass(frozen=True)
class Shown:
    """A picture that is ready to be put up."""

    number: int  # grows with every picture
    key: Hashable
    pixels: Image  # (h, w, 4) float32, contiguous, finite, no larger than half floats hold; row 0 at the bottom
    size: tuple[int, int]  # w and h of `pixels`
    samples: int
    seconds: float  # in the core
    notes: list[str] = field(default_factory=list)


class Viewport:
    """One viewport's thread and its newest picture."""

    def __init__(self, redraw: Callable[[], None]) -> None:
        self._redraw = redraw
        self._changed = threading.Condition()
        self._question: Question | None = None
        self._shown: Shown | None = None
        self._problem = ""
        self._closed = False
        self._number = 0
        self._thread: threading.Thread | None = None

    # ------------------------------------------------------------------------------------ called by Blender's thread

    def ask(self, question: Question) -> None:
        """A picture is wanted; whatever was asked before no longer is."""
        with self._changed:
            if self._closed:
                return
            self._question = question
            self._changed.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="Penumbra viewport", daemon=True)
                self._thread.start()

    @property
    def shown(self) -> Shown | None:
        with self._changed:
            return self._shown

    @property
    def problem(self) -> str:
        """Why there is no newer picture, in one sentence; empty if nothing is wrong."""
        with self._changed:
            return self._problem

    def tell_problem(self, problem: str) -> None:
        """Of Blender's own side: a scene that cannot be read."""
        with self._changed:
            self._problem = problem

    def close(self) -> None:
        """Ends the thread and gives its renderer back; never raises, waits two seconds at most."""
        with self._changed:
            self._closed = True
            self._question = self._shown = None
            self._changed.notify()
        if self._thread is not None:
            self._thread.join(_LONGEST_WAIT_S)

    # -------------------------------------------------------------------------------------------------- the thread

    def _work(self) -> None:
        renderer, device = None, ""
        swift = False
        done: Question | None = None
        while True:
            with self._changed:
                while not self._closed and (self._question is None or self._question is done):
                    self._changed.wait()
                if self._closed:
                    return
                question = self._question
            assert question is not None
            try:
                if renderer is None or device != question.device:
                    renderer = None
                    renderer, device = native.load().Renderer(question.device), question.device
                started = time.perf_counter()
                if not swift and question.smaller > 1:
                    self._paint(renderer, question, question.smaller, 1)
                    started = time.perf_counter()
                seconds = self._paint(renderer, question, 1, question.wanted.pixel_samples)
                swift = seconds < _SWIFT_S
            except picture.StoppedError:
                swift = swift and time.perf_counter() - started < _SWIFT_S
                continue
            except Exception as error:
                renderer = None
                self._tell(f"{errors.sentence_of(error)}")
            done = question

    def _paint(self, renderer: Any, question: Question, smaller: int, samples: int) -> float:
        """@returns seconds of the first sample. @raises StoppedError when a newer question came"""
        width, height = (max(1, -(-edge // smaller)) for edge in question.size)
        scene = question.export.scene
        scene.camera = question.camera((width, height))
        progress = ToldProgress(lambda _share, _text: self._stop_if_old(question))
        painter = picture.Painter(renderer, question.export, question.wanted, progress)
        first = 0.0
        for number in range(samples):
            self._stop_if_old(question)
            started = time.perf_counter()
            made = painter.sample(number)
            seconds = time.perf_counter() - started
            first = first or seconds
            self._show(question, made, (width, height), seconds)
        return first

    def _stop_if_old(self, question: Question) -> None:
        with self._changed:
            if self._closed or self._question is not question:
                raise picture.StoppedError

    def _show(self, question: Question, made: picture.Picture, size: tuple[int, int], seconds: float) -> None:
        pixels = displayable(made.planes[passes.COMBINED])
        with self._changed:
            if self._closed:
                raise picture.StoppedError
            self._number += 1
            self._shown = Shown(
                self._number, question.key, pixels, size, made.samples, seconds, list(dict.fromkeys(made.notes))
            )
            self._problem = ""
            self._redraw()

    def _tell(self, problem: str) -> None:
        with self._changed:
            if self._closed:
                return
            self._problem = problem
            self._redraw()


def displayable(colour: Image) -> Image:
    """A copy without NaN and without what half floats cannot hold."""
    pixels = np.nan_to_num(colour, nan=0.0, posinf=LARGEST_HALF, neginf=0.0)
    np.clip(pixels, -LARGEST_HALF, LARGEST_HALF, out=pixels)
    return np.ascontiguousarray(pixels, np.float32)
