"""How far a long job is: a bar on a terminal, sparse lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import TextIO

# A line every so many seconds is enough for a log file, and a bar need not be redrawn faster than eyes see.
_LINE_INTERVAL_S = 10.0
_BAR_INTERVAL_S = 0.1


class Progress:
    """Progress over a known amount of work, in stages of stated weight (estimated seconds will do).

    Usable as the core's `progress(fraction, text)` callable: it then reports within the current stage.
    """

    def __init__(self, total: float = 1.0, stream: TextIO | None = None, *, show: bool = True) -> None:
        self._stream = stream if stream is not None else sys.stderr
        self._show = show
        self._total = max(total, 1e-9)
        self._done = 0.0
        self._weight = 0.0
        self._reached = 0.0  # of the current stage; never falls, whatever the inner jobs of one report
        self._text = ""
        self._drawn_at = 0.0
        self._started = time.monotonic()
        self._bar: _Bar | None = None

    def __enter__(self) -> Progress:
        if self._show and self._stream.isatty():
            self._bar = _Bar(self._stream)
        self._drawn_at = time.monotonic()
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, tb: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def add_work(self, weight: float) -> None:
        """More work than first thought of."""
        self._total += weight

    def stage(self, text: str, weight: float) -> None:
        """Closes the stage before and opens the next one."""
        self._done += self._weight
        self._weight = weight
        self._reached = 0.0
        self._text = text
        self._draw(0.0, "", force=self._bar is not None)

    def finish(self) -> None:
        """Closes the last stage: 100 %."""
        self._done, self._weight, self._text = self._total, 0.0, "done"
        self._draw(0.0, "", force=self._bar is not None)

    def __call__(self, fraction: float, text: str = "") -> None:
        self._draw(fraction, text, force=False)

    def note(self, text: str) -> None:
        """A line that stays, above the bar."""
        if not self._show:
            return
        if self._bar is not None:
            self._bar.note(text)
        else:
            print(text, file=self._stream, flush=True)

    def _draw(self, fraction: float, detail: str, *, force: bool) -> None:
        if not self._show:
            return
        self._reached = max(self._reached, min(max(fraction, 0.0), 1.0))
        now = time.monotonic()
        if not force and now - self._drawn_at < (_BAR_INTERVAL_S if self._bar is not None else _LINE_INTERVAL_S):
            return
        self._drawn_at = now
        share, text = self._share(), self._said(detail)
        if self._bar is not None:
            self._bar.show(share, text)
        else:
            print(f"{share:4.0%}  {now - self._started:5.0f} s  {text}", file=self._stream, flush=True)

    def _share(self) -> float:
        return min(1.0, (self._done + self._weight * self._reached) / self._total)

    def _said(self, detail: str) -> str:
        return f"{self._text}: {detail}" if detail and detail not in self._text else self._text


class ToldProgress(Progress):
    """Progress that goes to a function, each time: `tell(share, text)`. The function may raise to end the work."""

    def __init__(self, tell: Callable[[float, str], None]) -> None:
        super().__init__(0.0, show=False)
        self._tell = tell

    def _draw(self, fraction: float, detail: str, *, force: bool) -> None:
        self._reached = max(self._reached, min(max(fraction, 0.0), 1.0))
        self._tell(self._share(), self._said(detail))


class _Bar:
    """The terminal's bar, drawn by rich."""

    def __init__(self, stream: TextIO) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        self._console = Console(file=stream)
        self._progress = RichProgress(
            BarColumn(bar_width=28),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            TextColumn("{task.description}", markup=False),
            console=self._console,
            auto_refresh=False,  # no thread of its own: the core's callbacks drive it
            transient=True,
        )
        self._task = self._progress.add_task("", total=1.0)
        self._progress.start()

    def show(self, share: float, text: str) -> None:
        self._progress.update(self._task, completed=share, description=text)
        self._progress.refresh()

    def note(self, text: str) -> None:
        self._progress.console.print(text, markup=False, highlight=False)

    def close(self) -> None:
        self._progress.stop()
