"""The summary's two drawings as SVG within the page: they follow its colours, in the light and in the dark."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from markupsafe import Markup, escape

WIDTH, HEIGHT = 640, 400
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 14, 12, 46
FLOOR = 1e-5  # a logarithmic axis has no zero


@dataclass(frozen=True)
class Point:
    """Medians with the tenth and ninetieth percentile, as (low, middle, high)."""

    x: tuple[float, float, float]
    y: tuple[float, float, float]
    label: str
    colour: str
    marker: str


@dataclass(frozen=True)
class Line:
    values: Sequence[tuple[float, float]]
    label: str
    colour: str
    marker: str
    href: Sequence[str] = field(default=())


def scatter(points: Sequence[Point], x_title: str, y_title: str) -> Markup:
    """Both axes logarithmic; whiskers from low to high."""
    if not points:
        return Markup("")
    x = _Logarithmic([value for point in points for value in point.x], _LEFT, WIDTH - _RIGHT)
    y = _Logarithmic([value for point in points for value in point.y], HEIGHT - _BOTTOM, _TOP)
    parts = [_axes(x, y, x_title, y_title)]
    for point in points:
        (x0, xm, x1), (y0, ym, y1) = [[scale(v) for v in values] for scale, values in ((x, point.x), (y, point.y))]
        parts.append(
            Markup('<g stroke="{0}" fill="{0}"><title>{1}</title>').format(point.colour, point.label)
            + Markup('<path d="M{:.1f} {:.1f}H{:.1f}M{:.1f} {:.1f}V{:.1f}" opacity=".55" fill="none"/>').format(
                x0, ym, x1, xm, y0, y1
            )
            + marker(point.marker, xm, ym)
            + Markup("</g>")
        )
    return _svg(parts, f"{y_title} against {x_title}")


def course(lines: Sequence[Line], x_title: str, y_title: str) -> Markup:
    """Lines over frames; the error's axis is logarithmic."""
    values = [value for line in lines for value in line.values]
    if not values:
        return Markup("")
    x = _Linear([frame for frame, _ in values], _LEFT, WIDTH - _RIGHT)
    y = _Logarithmic([value for _, value in values], HEIGHT - _BOTTOM, _TOP)
    parts = [_axes(x, y, x_title, y_title)]
    for line in lines:
        path = "M" + "L".join(f"{x(frame):.1f} {y(value):.1f}" for frame, value in line.values)
        parts.append(
            Markup(
                '<g stroke="{0}" fill="{0}"><title>{1}</title><path d="{2}" fill="none" stroke-width="1.6"/>'
            ).format(line.colour, line.label, path)
        )
        if len(line.values) <= 60:
            parts += [marker(line.marker, x(frame), y(value), 3.2) for frame, value in line.values]
        parts.append(Markup("</g>"))
    return _svg(parts, f"{y_title} over {x_title}")


_POLYGONS = {
    "s": (4, 45),
    "D": (4, 0),
    "^": (3, -90),
    "v": (3, 90),
    "p": (5, -90),
    "h": (6, 0),
    "<": (3, 180),
    ">": (3, 0),
}
_STARS = {"P": (4, 0), "X": (4, 45), "*": (5, -90)}


def marker(name: str, x: float, y: float, radius: float = 5.0) -> Markup:
    """A marker of the palette, by matplotlib's letter for it."""
    if name in _POLYGONS:
        count, turn = _POLYGONS[name]
        radii: Iterable[float] = [1.2 * radius] * count
    elif name in _STARS:
        count, turn = _STARS[name]
        radii, count = [1.35 * radius, 0.55 * radius] * count, 2 * count
    else:
        return Markup('<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" stroke="none"/>').format(x, y, radius)
    corners = []
    for i, r in enumerate(radii):
        angle = math.radians(turn + 360.0 * i / count)
        corners.append(f"{x + r * math.cos(angle):.1f},{y + r * math.sin(angle):.1f}")
    return Markup('<polygon points="{}" stroke="none"/>').format(" ".join(corners))


class _Logarithmic:
    """Decades; with few of them also 2 and 5."""

    def __init__(self, values: Sequence[float], start: float, end: float) -> None:
        known = [max(value, FLOOR) for value in values]
        low, high = math.log10(min(known)), math.log10(max(known))
        margin = max(0.06 * (high - low), 0.08)
        self._low, self._high, self._start, self._end = low - margin, high + margin, start, end
        steps = (1, 2, 5) if self._high - self._low < 2.2 else (1,)
        marks = [step * 10.0**decade for decade in range(-6, 9) for step in steps]
        self.ticks = [(mark, f"{mark:g}") for mark in marks if self._low <= math.log10(mark) <= self._high]

    def __call__(self, value: float) -> float:
        share = (math.log10(max(value, FLOOR)) - self._low) / (self._high - self._low)
        return self._start + share * (self._end - self._start)


class _Linear:
    def __init__(self, values: Sequence[float], start: float, end: float) -> None:
        self._low, self._high, self._start, self._end = min(values), max(values), start, end
        if self._high == self._low:
            self._low, self._high = self._low - 1, self._high + 1
        rough = max((self._high - self._low) / 7, 1)
        unit = 10.0 ** math.floor(math.log10(rough))
        step = next(unit * k for k in (1, 2, 5, 10) if unit * k >= rough)
        first = math.ceil(self._low / step)
        marks = [k * step for k in range(first, math.floor(self._high / step) + 1)]
        self.ticks = [(mark, f"{mark:.0f}") for mark in marks]

    def __call__(self, value: float) -> float:
        return self._start + (value - self._low) / (self._high - self._low) * (self._end - self._start)


def _axes(x: _Logarithmic | _Linear, y: _Logarithmic | _Linear, x_title: str, y_title: str) -> Markup:
    bottom = HEIGHT - _BOTTOM
    parts = []
    for value, text in x.ticks:
        at = x(value)
        parts.append(f'<path class="grid" d="M{at:.1f} {_TOP}V{bottom}"/>')
        parts.append(f'<text x="{at:.1f}" y="{bottom + 17}" text-anchor="middle">{escape(text)}</text>')
    for value, text in y.ticks:
        at = y(value)
        parts.append(f'<path class="grid" d="M{_LEFT} {at:.1f}H{WIDTH - _RIGHT}"/>')
        parts.append(f'<text x="{_LEFT - 7}" y="{at + 4:.1f}" text-anchor="end">{escape(text)}</text>')
    frame = f'<rect class="frame" x="{_LEFT}" y="{_TOP}" width="{WIDTH - _LEFT - _RIGHT}" height="{bottom - _TOP}"/>'
    middle = (_LEFT + WIDTH - _RIGHT) / 2
    titles = (
        f'<text class="axis-title" x="{middle}" y="{HEIGHT - 8}" text-anchor="middle">{escape(x_title)}</text>'
        f'<text class="axis-title" transform="translate(14 {(_TOP + bottom) / 2}) rotate(-90)" '
        f'text-anchor="middle">{escape(y_title)}</text>'
    )
    return Markup("".join(parts) + frame + titles)


def _svg(parts: Sequence[Markup], label: str) -> Markup:
    start = Markup('<svg viewBox="0 0 {} {}" role="img" aria-label="{}">').format(WIDTH, HEIGHT, label)
    return start + Markup("").join(parts) + Markup("</svg>")
