"""results.csv: one line per record, for spreadsheets."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

from ..records import ERROR_FIELDS, PART_FIELDS, Comparison, LightResult, Record
from ..targets import TARGETS

_MORE_ERRORS = ("leak", "over_darkening", "penumbra_width_ratio")
_TIMES = ("setup", "dynamic", "static", "kept", "view")
_SPREAD = {"median_ms": "median", "p10_ms": "p10", "p90_ms": "p90", "low_ms": "low", "high_ms": "high", "runs": "runs",
           "tight": "tight"}  # fmt: skip
_REACH = {"": "state", "_ms": "time_ms", "_low_ms": "low_ms", "_high_ms": "high_ms"}

COLUMNS = [
    "scene", "light", "shape", "technique", "settings", "sweep", "status", "reason", "on_pareto_front", "on_own_front",
    "picked", "headline", "headline_error",
    *(f"area_{name}" for name in (*ERROR_FIELDS, *_MORE_ERRORS)),
    *(f"irradiance_{name}" for name in (*ERROR_FIELDS, *_MORE_ERRORS)),
    "flip", "reference_standard_error", "within_reference_noise", "dominant_error",
    *(f"part_{name}" for name in PART_FIELDS),
    *(f"{time}_{figure}" for time in _TIMES for figure in _SPREAD),
    "memory_bytes", "everything_dynamic_median_ms", "everything_static_median_ms",
    # When the technique reaches an error, in the row of its settings as asked for; "target" is --target-rmse.
    *(f"to_{name}{figure}" for name in (*(f"{error:g}" for error in TARGETS), "target") for figure in _REACH),
]  # fmt: skip


def csv_text(comparison: Comparison) -> str:
    """Header and rows; figures that do not exist (an unsupported technique) are empty."""
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for scene in comparison.scenes:
        for light in scene.lights:
            for i, record in enumerate(light.records):
                row = {"scene": scene.path, "light": light.name, "shape": light.shape, **_row(record)}
                if record.status == "ok":
                    row["picked"] = light.pick is not None and light.pick.record == i
                if not record.is_sweep_step:
                    row |= _reaches(light, record.technique, comparison.options.get("target_rmse"))
                writer.writerow(row)
    return buffer.getvalue()


def _reaches(light: LightResult, technique: str, asked: float | None) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for target in light.targets:
        names = [f"{target.error:g}"] if target.error in TARGETS else []
        names += ["target"] if target.error == asked else []
        for reach in target.reaches:
            if reach.technique == technique:
                row |= {f"to_{name}{end}": getattr(reach, field) for name in names for end, field in _REACH.items()}
    return row


def _row(record: Record) -> dict[str, Any]:
    row: dict[str, Any] = {
        "technique": record.technique,
        "settings": json.dumps(record.settings, sort_keys=True),
        "sweep": record.sweep["setting"] if record.sweep else "",
        "status": record.status,
        "reason": record.reason,
    }
    if record.status != "ok":
        return row
    assert record.area is not None and record.irradiance is not None
    for prefix, errors in (("area", record.area), ("irradiance", record.irradiance)):
        row |= {f"{prefix}_{name}": errors.get(name, "") for name in (*ERROR_FIELDS, *_MORE_ERRORS)}
    row |= {f"part_{name}": record.area["parts"].get(name, "") for name in PART_FIELDS}
    for time in _TIMES:
        if time in record.time_ms:
            spread = record.time_ms[time]
            row |= {f"{time}_{figure}": getattr(spread, name) for figure, name in _SPREAD.items()}
    return row | {
        "on_pareto_front": record.on_pareto_front,
        "on_own_front": record.on_own_front,
        "headline": record.headline,
        "headline_error": record.headline_error,
        "flip": record.flip,
        "reference_standard_error": record.area["reference_standard_error"],
        "within_reference_noise": record.area["within_reference_noise"],
        "dominant_error": record.area["dominant"],
        "memory_bytes": record.memory_bytes,
        "everything_dynamic_median_ms": _median(record, "dynamic"),
        "everything_static_median_ms": _median(record, "static"),
    }


def _median(record: Record, frame: str) -> float | str:
    """With nothing left out; empty if that was not measured."""
    return record.everything_ms[frame].median if frame in record.everything_ms else ""
