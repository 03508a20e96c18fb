"""One comparison at a time, on a thread of its own that never touches Blender."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from .. import environment, native, picture, together
from ..compare import Comparer, Options
from ..progress import ToldProgress
from ..records import Comparison
from . import pictures

if TYPE_CHECKING:
    from ..bridge import SceneExport

_LONGEST_WAIT_S = 20.0  # the core hears of the end every tenth of a second; a step that does not may take this long

State = Literal["running", "done", "stopped", "failed"]


@dataclass(frozen=True)
class Order:
    """What is to be compared, all of it read before the thread starts."""

    export: SceneExport
    options: Options
    path: str  # of the file, as the report names it
    scene: int  # session_uid of Blender's scene, which gets the results
    device: str = ""
    view_by: str = ""
    stated: str = ""  # the view and the resolution in words


class Running:
    """A comparison that is under way, or over."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self.comparison: Comparison | None = None  # once it is done
        self.thumbnails: list[list[bytes]] = []  # by light and record, see pictures.thumbnail
        self.key = ""  # of the pictures in the cache; empty if they could not be kept
        self.problem = ""
        self._state: State = "running"
        self._share, self._text = 0.0, "starting"
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    # ------------------------------------------------------------------------------------ called by Blender's thread

    def start(self) -> None:
        self._thread = threading.Thread(target=self.run, name="Penumbra comparison", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Asks it to end; state tells when it has."""
        self._stop.set()

    def close(self) -> bool:
        """Ends it and waits until its thread is gone. @returns False if it is not, after a long wait"""
        self.cancel()
        if self._thread is not None:
            self._thread.join(_LONGEST_WAIT_S)
            return not self._thread.is_alive()
        return True

    @property
    def state(self) -> State:
        with self._lock:
            return self._state

    @property
    def cancelled(self) -> bool:
        return self._stop.is_set()

    @property
    def progress(self) -> tuple[float, str]:
        """Share of the work that is done, and what is being done."""
        with self._lock:
            return self._share, self._text

    # ---------------------------------------------------------------------------------------------------- the thread

    def run(self) -> None:
        """All of it; never raises."""
        try:
            self._compare(native.load())
        except picture.StoppedError:
            self._end("stopped")
        except BaseException as error:
            self._end("failed", native.sentence(error))
        else:
            self._end("done")

    def _compare(self, core: Any) -> None:
        order = self.order
        renderer = native.renderer(core, order.device, order.view_by)
        progress = ToldProgress(self._tell)
        comparer = Comparer(core, renderer, order.options, progress)
        progress.add_work(comparer.work(len(order.options.lights) or len(order.export.lights)) + 1.0)
        scene = comparer.compare(order.export, order.path)
        progress.stage("keeping the pictures", 1.0)
        facts = environment.collect(core, renderer, [])
        facts["command"] = "comparison panel"
        self.comparison = Comparison(facts, _recorded(order.options), [scene], comparer.failures)
        together.summarise(self.comparison, order.options.target_rmse)
        self.thumbnails = pictures.thumbnails(scene)
        self.key = pictures.keep(scene)

    def _tell(self, share: float, text: str) -> None:
        if self._stop.is_set():
            raise picture.StoppedError
        with self._lock:
            self._share, self._text = share, text

    def _end(self, state: State, problem: str = "") -> None:
        with self._lock:
            self._state, self.problem = state, problem


def _recorded(options: Options) -> dict[str, Any]:
    names = ("sweep", "reference_error", "target_rmse", "timing_seconds", "keep_everything", "measure_savings")
    return {name: getattr(options, name) for name in names} | {"warn_rmse": None, "fail_rmse": None}


_current: Running | None = None
_problem = ""  # of the last one, for the panel


def current() -> Running | None:
    return _current


def problem() -> str:
    """Why the last comparison failed; empty if it did not."""
    return _problem


def tell_problem(text: str) -> None:
    global _problem
    _problem = text


def begin(order: Order, *, wait: bool) -> Running:
    """Starts a comparison, ending the one that runs; with `wait` it is over when this returns."""
    global _current
    stop()
    tell_problem("")
    _current = Running(order)
    if wait:
        _current.run()
    else:
        _current.start()
    return _current


def collect(done: Callable[[Running], None]) -> bool:
    """Hands a comparison that is over to `done`, once. @returns True while one is running"""
    global _current
    running = _current
    if running is None:
        return False
    if running.state == "running":
        return True
    running.close()  # all that its thread still does is end
    _current = None
    tell_problem(running.problem if running.state == "failed" else "")
    done(running)
    return False


def stop() -> None:
    """Ends the comparison that runs, if one does, and forgets it."""
    global _current
    if _current is not None:
        _current.close()
        _current = None
