"""What the measured points say: one document, which table, plot and tests are made from."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from penumbra import environment

from . import curves, plan
from .curves import Sample
from .measuring import Measured
from .ours import TRUTH_FILE
from .plan import OURS, Point

TARGETS = (0.05, 0.02, 0.01, 0.005)
BLENDER_RATIO, EMBREE_RATIO, RATIO_TARGET = 0.1, 0.4, 0.01  # asked: at most this share of their time, to this error
SAME, SEEN = "same", "seen"
# Which truths count, the first of them that a curve has. "same": each is held against that of its own question, the
# share of the light's area or of its irradiance. "seen": all against irradiance, which is what a picture shows.
QUESTIONS = {SAME: ("area", "filtered", "irradiance"), SEEN: ("filtered", "irradiance")}
Document = dict[str, Any]


def collect(out: Path, scenes: list[str], settings: Document, command: str) -> Document:
    """All of a folder's points, figures of the scenes, and the targets."""
    return {
        "schema": 1,
        "command": command,
        "environment": machine(),
        "settings": settings,
        "scenes": [scene(out / name, name) for name in scenes if (out / name / TRUTH_FILE).is_file()],
    }


def machine() -> Document:
    return {
        "cpu": environment.cpu_model(),
        "cores": environment.usable_cores(),
        "memory_bytes": environment.memory_bytes(),
        "os": environment.operating_system(),
        "commit": environment.commit_of_checkout(),
    }


def scene(folder: Path, name: str) -> Document:
    points = [_point(json.loads(file.read_text("utf-8"))) for file in sorted((folder / "points").glob("*.json"))]
    found: dict[str, list[Measured]] = {}
    for measured in points:
        found.setdefault(measured.point.curve, []).append(measured)
    facts = json.loads((folder / "facts.json").read_text("utf-8"))
    document: Document = {
        "name": name,
        "facts": facts,
        "curves": [_curve(curve, found[curve]) for curve in _in_order(found)],
    }
    for which in (SAME, SEEN):
        document[f"targets_{which}"] = [target(document["curves"], error, which) for error in TARGETS]
    return document


def _point(kept: Document) -> Measured:
    point = Point(kept["worker"], kept["curve"], kept["label"], kept["settings"])
    return Measured(point, kept["runs"], kept["errors"], kept["failure"])


def _in_order(found: dict[str, list[Measured]]) -> list[str]:
    """Ours first, then the others as plan.py lists them."""
    theirs = [curve.id for curve in plan.CURVES if curve.id in found]
    return [name for name in found if name not in theirs] + theirs


def _curve(name: str, points: list[Measured]) -> Document:
    known = {curve.id: curve for curve in plan.CURVES}
    return {
        "id": name,
        "title": known[name].title if name in known else name,
        "group": known[name].group if name in known else OURS,
        "points": [_figures(each) for each in points if each.runs and each.errors],
        "failures": sorted({each.failure for each in points if each.failure}),
    }


def _figures(each: Measured) -> Document:
    figures: Document = {
        "label": each.point.label,
        "settings": each.point.settings,
        "runs": len(each.runs),
        "errors": each.errors,
    }
    for key in ("wall_ms", "cpu_ms", "view_ms", "static_ms", "setup_ms"):
        if each.times(key):
            figures[key] = each.median(key)
    return figures


def samples_of(curve: Document, which: str, clock: str) -> list[Sample]:
    """@param clock "wall_ms", or "cpu_ms": processor time over the number of cores"""
    cores = environment.usable_cores() if clock == "cpu_ms" else 1
    found = []
    for point in curve["points"]:
        question = next((each for each in QUESTIONS[which] if each in point["errors"]), None)
        if question is not None:
            found.append(Sample(own_error(point["errors"][question]), point[clock] / cores, point["label"]))
    return found


def own_error(errors: Document) -> float:
    """The RMSE without the truth's noise, which is independent; at least half of that noise, for less is not known."""
    noise = float(errors.get("reference_standard_error", 0.0))
    return math.sqrt(max(float(errors["rmse"]) ** 2 - noise**2, noise**2 / 4))


def target(all_curves: list[Document], error: float, which: str) -> Document:
    """Who reaches the error when, the best of ours, and its share of the others' time; by both clocks."""
    document: Document = {"error": error, "times": {}}
    for clock in ("wall_ms", "cpu_ms"):
        times = {curve["id"]: curves.time_to(error, samples_of(curve, which, clock)) for curve in all_curves}
        document["times"][clock] = times
        best = {group: _least(all_curves, times, group) for group in (OURS, "blender", "embree")}
        document[clock] = {f"best_{group}": name for group, name in best.items()}
        for group in ("blender", "embree"):
            mine, their = (times.get(best[each] or "") for each in (OURS, group))
            document[clock][f"over_{group}"] = mine / their if mine is not None and their is not None else None
    winner = document["wall_ms"]["best_ours"]
    if winner:
        own = next(curve for curve in all_curves if curve["id"] == winner)
        at = curves.cheapest(error, samples_of(own, which, "wall_ms"))
        document["setting"] = at.label if at else ""
    return document


def _least(all_curves: list[Document], times: dict[str, float | None], group: str) -> str | None:
    there = {curve["id"]: times[curve["id"]] for curve in all_curves if curve["group"] == group}
    reached = {name: time for name, time in there.items() if time is not None}
    return min(reached, key=lambda name: reached[name]) if reached else None
