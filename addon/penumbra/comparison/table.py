"""What the table of a comparison shows, in which order, and which row is the cheapest. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, Protocol

SortBy = Literal["ERROR", "TIME", "NAME"]


class Row(Protocol):
    """What is read of a row; Blender's property groups have it."""

    name: str
    light: str
    technique: str
    settings: str
    status: str
    error: float
    time_ms: float
    is_sweep_step: bool


def order(rows: Sequence[Row], by: SortBy, *, reverse: bool = False) -> list[int]:
    """Indices of the rows as they are to stand; those without the figure stand last, whichever way it is sorted."""

    def known(index: int) -> bool:
        return by == "NAME" or _figure(rows[index], by) is not None

    def key(index: int) -> tuple[float, str, int]:
        row = rows[index]
        figure = 0.0 if by == "NAME" else _figure(row, by) or 0.0
        return figure, row.name.casefold(), index

    present = sorted((i for i in range(len(rows)) if known(i)), key=key, reverse=reverse)
    return present + sorted((i for i in range(len(rows)) if not known(i)), key=lambda i: rows[i].name.casefold())


def _figure(row: Row, by: SortBy) -> float | None:
    value = row.error if by == "ERROR" else row.time_ms
    return value if row.status == "ok" and math.isfinite(value) and value >= 0.0 else None


def cheapest(rows: Sequence[Row], error: float) -> int | None:
    """The first row of the cheapest technique, with its settings, that stays within `error` at every light.

    Its cost is the sum of its times over the lights. Lights at which nothing could be measured say nothing.
    """
    usable = [i for i, row in enumerate(rows) if _figure(row, "ERROR") is not None and _figure(row, "TIME") is not None]
    lights = {rows[i].light for i in usable}
    found: dict[tuple[str, str], dict[str, int]] = {}
    for i in usable:
        if rows[i].error <= error:
            found.setdefault((rows[i].technique, rows[i].settings), {})[rows[i].light] = i
    everywhere = [list(places.values()) for places in found.values() if set(places) == lights]
    if not everywhere:
        return None
    return min(min(everywhere, key=lambda indices: sum(rows[i].time_ms for i in indices)))


def error_text(value: float) -> str:
    """Three digits, as short as they go."""
    if not math.isfinite(value) or value < 0.0:
        return "–"
    return f"{value:.1e}" if 0.0 < value < 1e-4 else f"{value:.3g}"
