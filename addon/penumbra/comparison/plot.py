"""Error against time as a small picture for the panel, drawn from the records in a few milliseconds.

The report has the large one (report/plots.py); a picture of it would be unreadable in a sidebar, and the library that
draws it takes a second to load.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..images import Bytes
from ..report import palette

WIDTH, HEIGHT = 400, 368  # nearly square, as the place is that Blender gives an icon
_LEFT, _RIGHT, _BOTTOM, _TOP = 76, 14, 36, 12  # margins
_BACK, _GRID, _INK = (38, 38, 40), (66, 66, 70), (200, 200, 204)
_FLOOR = 1e-6  # a logarithmic axis has no zero

Colour = tuple[int, int, int]
Canvas = npt.NDArray[np.float32]

# 5 x 7 dots a letter, rows from the top.
_LETTERS = {
    "0": "0e11131519110e", "1": "040c040404040e", "2": "0e11010204081f", "3": "1f02040201110e", "4": "02060a121f0202",
    "5": "1f101e0101110e", "6": "0608101e11110e", "7": "1f010204080808", "8": "0e11110e11110e", "9": "0e11110f01020c",
    ".": "00000000000c0c", "-": "0000001f000000", "e": "00000e111f100e", "m": "00001a15151515", "s": "00000e100e011e",
    " ": "00000000000000",
}  # fmt: skip
_DOT = 2  # pixels a dot


@dataclass(frozen=True)
class Point:
    time_ms: float
    error: float
    low_ms: float
    high_ms: float
    on_front: bool = False
    active: bool = False


@dataclass(frozen=True)
class Curve:
    """A technique's points, joined by a line."""

    number: int  # of the technique, for its colour
    points: Sequence[Point]


@dataclass
class Plot:
    curves: list[Curve] = field(default_factory=list)
    noise: float = 0.0  # the reference's own; 0 for none
    target: float = 0.0  # the error that is asked for; 0 for none


def draw(plot: Plot) -> Bytes:
    """(HEIGHT, WIDTH, 4), row 0 at the bottom; logarithmic axes: up is more error, right is more time."""
    canvas: Canvas = np.empty((HEIGHT, WIDTH, 3), np.float32)
    canvas[:] = _BACK
    points = [point for curve in plot.curves for point in curve.points]
    if points:
        across = _Axis([edge for p in points for edge in (p.low_ms, p.high_ms, p.time_ms)], _LEFT, WIDTH - _RIGHT)
        extra = [value for value in (plot.noise, plot.target) if value > 0]
        up = _Axis([p.error for p in points] + extra, _BOTTOM, HEIGHT - _TOP)
        _grid(canvas, across, up)
        _marks(canvas, plot, across, up)
        _front(canvas, [p for p in points if p.on_front], across, up)
        for curve in plot.curves:
            _curve(canvas, curve, across, up)
    picture = np.full((HEIGHT, WIDTH, 4), 255, np.uint8)
    picture[..., :3] = np.rint(np.clip(canvas, 0, 255))
    return picture


class _Axis:
    """Values to pixels, logarithmic, with a little room at both ends."""

    def __init__(self, values: Iterable[float], start_px: int, end_px: int) -> None:
        logs = [math.log10(max(value, _FLOOR)) for value in values if math.isfinite(value)]
        low, high = min(logs), max(logs)
        room = max(0.08 * (high - low), 0.15)
        self._low, self._high = low - room, high + room
        self._start, self._end = start_px, end_px

    def __call__(self, value: float) -> float:
        share = (math.log10(max(value, _FLOOR)) - self._low) / (self._high - self._low)
        return self._start + share * (self._end - self._start)

    def ticks(self) -> list[float]:
        """Decades; 2 and 5 between them where there are few."""
        decades = range(math.floor(self._low), math.ceil(self._high) + 1)
        steps = (1,) if self._high - self._low > 2.5 else (1, 2, 5)
        values = [step * 10.0**decade for decade in decades for step in steps]
        return [value for value in values if self._low <= math.log10(value) <= self._high]


def _grid(canvas: Canvas, across: _Axis, up: _Axis) -> None:
    free_from = 0.0
    for value in across.ticks():
        x = across(value)
        canvas[_BOTTOM : HEIGHT - _TOP, round(x)] = _GRID
        text = _milliseconds(value)
        left = x - _width(text) / 2
        if left >= free_from and left + _width(text) <= WIDTH:
            _write(canvas, text, left, 12)
            free_from = left + _width(text) + 8
    free_from = 0.0
    for value in up.ticks():
        y = up(value)
        canvas[round(y), _LEFT : WIDTH - _RIGHT] = _GRID
        if y - 7 >= free_from and y + 7 <= HEIGHT:
            text = _number(value)
            _write(canvas, text, _LEFT - 8 - _width(text), y - 7)
            free_from = y + 10


def _number(value: float) -> str:
    return f"{value:.0e}".replace("e-0", "e-") if value < 1e-3 else f"{value:g}"


def _milliseconds(value: float) -> str:
    return f"{value / 1000:g} s" if value >= 1000 else f"{value:g} ms"


def _marks(canvas: Canvas, plot: Plot, across: _Axis, up: _Axis) -> None:
    """The error that is asked for as a dashed line, the reference's noise as a dotted one."""
    for value, dash, gap, colour in ((plot.target, 10, 6, (120, 200, 120)), (plot.noise, 2, 5, (150, 150, 154))):
        if value > 0:
            columns = [x for x in range(_LEFT, WIDTH - _RIGHT) if (x - _LEFT) % (dash + gap) < dash]
            canvas[round(up(value)), columns] = colour


def _front(canvas: Canvas, points: list[Point], across: _Axis, up: _Axis) -> None:
    """The staircase under which nothing lies."""
    ordered = sorted(points, key=lambda point: point.time_ms)
    for before, after in itertools.pairwise(ordered):
        corner = (across(after.time_ms), up(before.error))
        _line(canvas, (across(before.time_ms), up(before.error)), corner, 6, (88, 88, 92))
        _line(canvas, corner, (across(after.time_ms), up(after.error)), 6, (88, 88, 92))


def _curve(canvas: Canvas, curve: Curve, across: _Axis, up: _Axis) -> None:
    code = palette.colour(curve.number).lstrip("#")
    colour = (int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16))
    places = [(across(point.time_ms), up(point.error)) for point in curve.points]
    for start, end in itertools.pairwise(places):
        _line(canvas, start, end, 2.5, colour)
    for point, (x, y) in zip(curve.points, places, strict=True):
        _line(canvas, (across(point.low_ms), y), (across(point.high_ms), y), 1.5, colour)
        if point.active:
            _line(canvas, (x, y), (x, y), 22, (255, 255, 255))
            _line(canvas, (x, y), (x, y), 17, _BACK)
        _line(canvas, (x, y), (x, y), 12, colour)


def _line(canvas: Canvas, start: tuple[float, float], end: tuple[float, float], width: float, colour: Colour) -> None:
    """With round ends, so that a line from a place to itself is a disc."""
    (x0, y0), (x1, y1), reach = start, end, width / 2 + 1
    left, right = max(0, math.floor(min(x0, x1) - reach)), min(WIDTH, math.ceil(max(x0, x1) + reach) + 1)
    bottom, top = max(0, math.floor(min(y0, y1) - reach)), min(HEIGHT, math.ceil(max(y0, y1) + reach) + 1)
    if left >= right or bottom >= top:
        return
    x, y = np.arange(left, right, dtype=np.float32)[None, :], np.arange(bottom, top, dtype=np.float32)[:, None]
    dx, dy = x1 - x0, y1 - y0
    squared = dx * dx + dy * dy
    along = np.clip(((x - x0) * dx + (y - y0) * dy) / squared, 0, 1) if squared > 0 else np.zeros_like(x + y)
    distance = np.hypot(x - (x0 + along * dx), y - (y0 + along * dy))
    cover = np.clip(width / 2 + 0.5 - distance, 0, 1)[..., None]
    window = canvas[bottom:top, left:right]
    window += cover * (np.array(colour, np.float32) - window)


def _width(text: str) -> int:
    return 6 * _DOT * len(text) - _DOT


def _write(canvas: Canvas, text: str, left: float, bottom: float) -> None:
    x, y = round(left), round(bottom)
    for letter in text:
        code = _LETTERS[letter]
        for row in range(7):
            bits = int(code[2 * row : 2 * row + 2], 16)
            for column in range(5):
                if bits >> (4 - column) & 1:
                    low = y + (6 - row) * _DOT
                    canvas[low : low + _DOT, x + column * _DOT : x + (column + 1) * _DOT] = _INK
        x += 6 * _DOT
