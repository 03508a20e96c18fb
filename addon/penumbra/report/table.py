"""results.csv: one line per record, for spreadsheets."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

from ..records import ERROR_FIELDS, PART_FIELDS, Comparison, Record

_MORE_ERRORS = ("leak", "over_darkening", "penumbra_width_ratio")
_TIMES = ("setup", "dynamic", "static", "view")

COLUMNS = [
    "scene", "light", "shape", "technique", "settings", "sweep", "status", "reason", "on_pareto_front",
    *(f"area_{name}" for name in (*ERROR_FIELDS, *_MORE_ERRORS)),
    *(f"irradiance_{name}" for name in (*ERROR_FIELDS, *_MORE_ERRORS)),
    "flip", "reference_standard_error", "within_reference_noise", "dominant_error",
    *(f"part_{name}" for name in PART_FIELDS),
    *(f"{time}_{figure}" for time in _TIMES for figure in ("median_ms", "p10_ms", "p90_ms", "runs")),
    "memory_bytes",
]  # fmt: skip


def csv_text(comparison: Comparison) -> str:
    """Header and rows; figures that do not exist (an unsupported technique) are empty."""
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for scene in comparison.scenes:
        for light in scene.lights:
            for record in light.records:
                writer.writerow({"scene": scene.path, "light": light.name, "shape": light.shape, **_row(record)})
    return buffer.getvalue()


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
            row |= {
                f"{time}_median_ms": spread.median,
                f"{time}_p10_ms": spread.p10,
                f"{time}_p90_ms": spread.p90,
                f"{time}_runs": spread.runs,
            }
    return row | {
        "on_pareto_front": record.on_pareto_front,
        "flip": record.flip,
        "reference_standard_error": record.area["reference_standard_error"],
        "within_reference_noise": record.area["within_reference_noise"],
        "dominant_error": record.area["dominant"],
        "memory_bytes": record.memory_bytes,
    }
