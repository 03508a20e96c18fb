"""summary.html: one file that opens offline, in the look of the reports it links to."""

from __future__ import annotations

import functools
import math
from importlib import resources
from typing import Any

from ..report import html
from . import chart
from .summary import Book, Shot, Technique

MAX_COURSES = 12  # drawings of error over frames; each shot's own figures are in the table
_FULL_SCALE = 0.5  # as in the error pictures


def page(book: Book) -> str:
    """The whole page as text."""
    text: str = _template().render(
        book=book,
        environment=book.environment,
        style=html.style(),
        own_style=_text("summary.css"),
        scatter=_scatter(book.techniques),
        courses=_courses(book),
        heat=_heat,
        finite=math.isfinite,
        marker=lambda technique: chart.marker(technique.marker, 7, 7),
        duration=duration,
        failed_items={failure.item for failure in book.failures} - {shot.id for shot in book.shots},
    )
    return text


def duration(seconds: float) -> str:
    """ "90 ms", "4.2 s", "12 min 5 s", "3 h 20 min"."""
    if seconds < 60:
        return f"{seconds:.1f} s" if seconds >= 0.95 else f"{1000 * seconds:.0f} ms"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


def _heat(error: float) -> str:
    """Strength of a cell's colour in percent: the square root keeps small errors apart."""
    return f"{100 * min(1.0, math.sqrt(max(error, 0.0) / _FULL_SCALE)):.0f}%"


def _scatter(techniques: tuple[Technique, ...]) -> Any:
    points = []
    for each in techniques:
        if each.error is None or each.time_ms is None:
            continue
        time, error = each.time_ms, each.error
        points.append(
            chart.Point(
                (time.p10, time.median, time.p90),
                (error.p10, error.median, error.p90),
                f"{each.title}: error {html.format_error(error.median)}, {time.median:.3g} ms",
                each.colour,
                each.marker,
            )
        )
    return chart.scatter(points, "time of a dynamic frame (ms)", "penumbra RMSE")


def _courses(book: Book) -> list[dict[str, Any]]:
    """Error over frames, for each scene and camera that has three frames or more; the worst ones first."""
    takes: dict[tuple[str, str], list[Shot]] = {}
    for shot in book.shots:  # worst first
        takes.setdefault((shot.name, shot.camera), []).append(shot)
    found = []
    for (name, camera), shots in takes.items():
        if len(shots) < 3 or book.mode != "compare":
            continue
        shots = sorted(shots, key=lambda shot: shot.frame)
        lines = []
        for technique in book.techniques:
            values = [(float(s.frame), error) for s in shots if math.isfinite(error := s.error_of(technique.id))]
            if values:
                lines.append(chart.Line(values, technique.title, technique.colour, technique.marker))
        several = sum(other == name for other, _ in takes) > 1
        title = f"{name}, {camera}" if several else name
        found.append({"title": title, "drawing": chart.course(lines, "frame", "penumbra RMSE")})
    return found[:MAX_COURSES]


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


@functools.cache
def _template() -> Any:
    return html.template(_text("summary.html.j2"))
