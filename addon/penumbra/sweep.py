"""The steps of a sweep: which settings a technique is tried with. Pure functions of what the core says of it.

A setting with a list `sweep` is a knob; its values go from cheap to costly. A technique's `knob` is the one that trades
error for time the most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from .records import Settings, Value

MODES = ("off", "quick", "full")
QUICK_STEPS = 3


def steps(info: dict[str, Any], settings: Settings, mode: str) -> list[Settings]:
    """What each step changes of the settings as they stand; what `settings` lacks has its default. No step comes twice.

    quick: three values of the technique's knob, up to the next above the standing one, and the other choices of swept
    choices.
    full: every value of every knob, one at a time, and then a ladder: all knobs rise together. Where one knob alone
    saturates (a fine filter on a coarse map), the ladder goes on. It has as many rungs as the longest list, less the
    last, so that the number of steps grows with the sum of the lists' lengths and not with their product.
    """
    if mode == "off":
        return []
    standing = {setting["id"]: settings.get(setting["id"], setting["default"]) for setting in info["settings"]}
    knobs = [setting for setting in info["settings"] if setting["sweep"] and _matters(setting, standing)]
    if mode == "quick":
        changes = _singles([_thinned(knob, info["knob"], standing) for knob in knobs], standing)
    else:
        changes = _singles([(str(knob["id"]), list(knob["sweep"])) for knob in knobs], standing)
        changes += _ladder([knob for knob in knobs if _rises_from(knob, standing)], standing)
    return list({tuple(sorted(change.items())): change for change in changes}.values())


def entry(change: Settings) -> dict[str, Any]:
    """How a record names its step: {"setting", "value", "changed"}; of a joint step both texts list all."""
    if len(change) == 1:
        ((setting, value),) = change.items()
        return {"setting": setting, "value": value, "changed": dict(change)}
    return {
        "setting": ", ".join(change),
        "value": ", ".join(str(value) for value in change.values()),
        "changed": dict(change),
    }


def _matters(setting: dict[str, Any], standing: Settings) -> bool:
    return all(standing.get(other) == value for other, value in setting.get("sweep_when", {}).items())


def _is_choice(setting: dict[str, Any]) -> bool:
    return setting["type"] in ("choice", "bool")


def _thinned(setting: dict[str, Any], knob: str, standing: Settings) -> tuple[str, list[Value]]:
    name, values = str(setting["id"]), list(setting["sweep"])
    if name != knob:
        return name, values if _is_choice(setting) else []
    if len(values) <= QUICK_STEPS:
        return name, values
    above = next((i for i, value in enumerate(values) if value > standing[name]), len(values))
    # Never the dearest: it often takes longer than all others together.
    top = min(max(above, QUICK_STEPS - 1), len(values) - 2)
    return name, [values[_nearest(i * top / (QUICK_STEPS - 1))] for i in range(QUICK_STEPS)]


def _singles(knobs: list[tuple[str, list[Value]]], standing: Settings) -> list[Settings]:
    return [{name: value} for name, values in knobs for value in values if value != standing[name]]


def _rises_from(setting: dict[str, Any], standing: Settings) -> bool:
    """A choice whose standing value is none of its steps (a filter of another kind) has no place on a ladder."""
    return not _is_choice(setting) or standing[setting["id"]] in setting["sweep"]


def _ladder(knobs: list[dict[str, Any]], standing: Settings) -> list[Settings]:
    return [change for change in _rungs(knobs, standing) if len(change) > 1]


def _rungs(knobs: list[dict[str, Any]], standing: Settings) -> Iterator[Settings]:
    rungs = max((len(knob["sweep"]) for knob in knobs), default=0)
    for rung in range(rungs - 1):
        values = {str(k["id"]): k["sweep"][_nearest(rung * (len(k["sweep"]) - 1) / (rungs - 1))] for k in knobs}
        yield {name: value for name, value in values.items() if value != standing[name]}


def _nearest(position: float) -> int:
    """Halves go up, in every place alike."""
    return math.floor(position + 0.5)
