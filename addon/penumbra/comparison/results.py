"""Results in the scene: put there when a comparison is done, read again by panels, the report and the image editor."""

from __future__ import annotations

import base64
import binascii
import functools
import json
import math
import zlib
from typing import Any

from .. import verdict
from ..records import Comparison, LightResult, Record, from_json, to_json
from ..report import palette
from . import pictures, plot, table
from .running import Running


def store(scene: Any, running: Running) -> None:
    """Replaces what the scene held."""
    comparison = running.comparison
    assert comparison is not None
    kept = scene.penumbra_comparison
    clear(kept)
    numbers = palette.order(comparison)
    (result,) = comparison.scenes
    for index, light in enumerate(result.lights):
        entry = kept.result_lights.add()
        entry.name = light.name
        thumbnails = running.thumbnails[index]
        entry.thumbnail = thumbnails[0].decode()
        for number, record in enumerate(light.records):
            row = kept.rows.add()
            row.name = record.label()
            row.technique, row.light, row.light_index, row.record = record.technique, light.name, index, number
            row.settings = json.dumps(record.settings, sort_keys=True)
            row.status, row.reason = record.status, record.reason
            row.error, row.time_ms = _figure(record.headline), _figure(_time(record))
            row.outside = bool(record.warnings)
            row.on_front, row.is_sweep_step = record.on_pareto_front, record.is_sweep_step
            row.colour = numbers[record.technique]
            row.thumbnail = thumbnails[1 + number].decode()
    kept.shown_light = result.lights[0].name if result.lights else ""
    kept.noise = max((float(light.reference_info.get("standard_error", 0.0)) for light in result.lights), default=0.0)
    width, height = result.size
    parts = [running.order.stated or result.camera, f"{width} x {height}", f"frame {result.frame}"]
    kept.heading = ", ".join(parts)
    kept.key = running.key
    kept.document = packed(comparison)
    shown = listed(kept)
    kept.active_row = shown[0] if shown else 0


def clear(kept: Any) -> None:
    kept.rows.clear()
    kept.result_lights.clear()
    kept.heading = kept.key = kept.document = kept.shown_light = ""
    kept.active_row, kept.noise = 0, 0.0


def _time(record: Record) -> float:
    return record.time_ms["dynamic"].median if "dynamic" in record.time_ms else math.nan


def _figure(value: float) -> float:
    return value if math.isfinite(value) else -1.0


def packed(comparison: Comparison) -> str:
    return packed_text(json.dumps(to_json(comparison), separators=(",", ":"), allow_nan=False))


def packed_text(text: str) -> str:
    """As a scene's property holds it."""
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()


@functools.lru_cache(maxsize=4)
def unpacked(document: str) -> Comparison | None:
    """The records without their pixels; None for what cannot be read. One object for all who ask: do not change it."""
    try:
        return from_json(json.loads(zlib.decompress(base64.b64decode(document))))
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError, binascii.Error, zlib.error):
        return None


def listed(kept: Any) -> list[int]:
    """Indices of the rows of the light that is shown, in the table's order."""
    rows = list(kept.rows)
    ordered = table.order(rows, kept.sort_by, reverse=kept.sort_reverse)
    return [index for index in ordered if is_shown(kept, rows[index])]


def is_shown(kept: Any, row: Any) -> bool:
    return not kept.shown_light or row.light == kept.shown_light


def active(kept: Any) -> Any | None:
    """The active row, if there is one."""
    return kept.rows[kept.active_row] if 0 <= kept.active_row < len(kept.rows) else None


def light_of(kept: Any, row: Any) -> LightResult | None:
    comparison = unpacked(kept.document)
    if comparison is None or not comparison.scenes or row.light_index >= len(comparison.scenes[0].lights):
        return None
    light: LightResult = comparison.scenes[0].lights[row.light_index]
    return light


def record_of(kept: Any, row: Any) -> Record | None:
    """All that is known of a row."""
    light = light_of(kept, row)
    return light.records[row.record] if light is not None and row.record < len(light.records) else None


def plot_of(kept: Any) -> plot.Plot:
    """Error against time at the light that is shown, from the records."""
    made = plot.Plot(target=kept.target)
    row = next((row for row in kept.rows if is_shown(kept, row)), None)
    light = light_of(kept, row) if row is not None else None
    if light is None:
        return made
    made.noise = float(light.reference_info.get("standard_error", 0.0))
    chosen = active(kept)
    colours = {row.technique: row.colour for row in kept.rows}
    from ..report.plots import curves

    for technique, lines in curves(light).items():
        for line in lines:
            points = [_point(light, record, chosen) for record in line]
            made.curves.append(plot.Curve(colours.get(technique, 0), points))
    return made


def _point(light: LightResult, record: Record, chosen: Any | None) -> plot.Point:
    time = record.time_ms["dynamic"]
    is_active = chosen is not None and chosen.light == light.name and light.records[chosen.record] is record
    return plot.Point(time.median, record.headline, time.low, time.high, record.on_pareto_front, is_active)


def pictures_of(kept: Any) -> pictures.Pictures | None:
    """The whole pictures, None if this machine has them no more."""
    return pictures.load(kept.key)


def sentences(kept: Any) -> list[str]:
    """What is to be said of the light that is shown, with the budget as it stands now."""
    row = next((row for row in kept.rows if is_shown(kept, row)), None)
    light = light_of(kept, row) if row is not None else None
    return verdict.sentences(light, kept.target) if light is not None else []


def notes(kept: Any) -> list[str]:
    """What was decided while the scene was read, and what failed."""
    comparison = unpacked(kept.document)
    if comparison is None:
        return []
    failed = [f"{failure.what}: {failure.reason}" for failure in comparison.failures]
    return [note for scene in comparison.scenes for note in scene.notes] + failed
