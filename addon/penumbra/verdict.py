"""What the records of one light say: front, budgets, and the sentences at the top of a report. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .records import Budget, LightResult, Record

BUDGETS = (0.1, 0.05, 0.02, 0.01, 1 / 255)
"""Headline errors that a report answers "who is cheapest?" for; the last is one step of an 8-bit picture."""


def comparable(light: LightResult) -> list[int]:
    """Indices of the records that have an error and a time."""
    return [
        i
        for i, record in enumerate(light.records)
        if record.status == "ok" and math.isfinite(record.headline) and "dynamic" in record.time_ms
    ]


def judge(light: LightResult, target: float | None, pareto_front: Callable[..., Sequence[bool]]) -> None:
    """Fills in the light's front, budgets, cheapest record within the target, and sentences.

    Times are dynamic frames: what a game pays when something moves. Errors are the headline figures.
    """
    indices = comparable(light)
    times = [light.records[i].time_ms["dynamic"].median for i in indices]
    errors = [light.records[i].headline for i in indices]
    for i, on_front in zip(indices, pareto_front(times, errors) if indices else [], strict=True):
        light.records[i].on_pareto_front = bool(on_front)
    light.budgets = [budget(light, error) for error in BUDGETS]
    light.cheapest_within_target = light.cheapest_settings = None
    if target is not None:
        found = budget(light, target).record
        if found is not None:
            light.cheapest_within_target = light.records[found].technique
            light.cheapest_settings = light.records[found].settings
    light.sentences = sentences(light, target)


def budget(light: LightResult, error: float) -> Budget:
    """The cheapest record within `error`. Those whose time intervals overlap the winner's are ties."""
    within = [i for i in comparable(light) if light.records[i].headline <= error]
    if not within:
        return Budget(error, None, None)
    winner = min(within, key=lambda i: light.records[i].time_ms["dynamic"].median)
    ties = [i for i in within if i != winner and _overlap(light.records[i], light.records[winner])]
    return Budget(error, light.records[winner].technique, winner, ties)


def _overlap(a: Record, b: Record) -> bool:
    ta, tb = a.time_ms["dynamic"], b.time_ms["dynamic"]
    return ta.low <= tb.high and tb.low <= ta.high


def milliseconds(value: float) -> str:
    """Three significant digits: "0.0431 ms", "4.31 ms", "431 ms", "4.31 s"."""
    if value >= 1000:
        return f"{value / 1000:.3g} s"
    return f"{value:.0f} ms" if value >= 100 else f"{value:.3g} ms"


def error_name(error: float) -> str:
    return "1/255" if abs(error - 1 / 255) < 1e-12 else f"{error:g}"


def sentences(light: LightResult, target: float | None) -> list[str]:
    """What a reader should take away, each sentence true by the numbers beside it."""
    indices = comparable(light)
    if not indices:
        return ["No technique could be measured at this light."]
    records = light.records
    said: list[str] = []
    reference = records[indices[0]].area or {}
    if not reference.get("pixels", 1):
        return ["This light reaches no visible pixel: there is nothing to compare."]
    if not reference.get("penumbra_pixels", 1):
        said.append("No visible pixel is partly lit: errors are over the whole mask instead of the penumbra.")

    best = min(indices, key=lambda i: records[i].headline)
    fast = min(indices, key=lambda i: records[i].time_ms["dynamic"].median)
    if best == fast:
        said.append(f"{records[best].label()} is the most accurate and the fastest: {_figures(records[best])}.")
    else:
        said.append(f"Most accurate: {records[best].label()}, {_figures(records[best])}.")
        tied = [records[i].label() for i in indices if i != fast and _overlap(records[i], records[fast])]
        said.append(f"Fastest: {records[fast].label()}, {_figures(records[fast])}{_tied(tied)}.")
    if target is not None:
        said.append(_target_sentence(light, target))
    noise = [i for i in indices if (records[i].area or {}).get("within_reference_noise")]
    if noise:
        names = ", ".join(dict.fromkeys(records[i].label() for i in noise))
        one = "differs" if len(noise) == 1 else "differ"
        said.append(f"{names} {one} from the reference by no more than the reference's own noise.")
    info = light.reference_info
    if info and not info.get("reached", True):
        said.append(
            "At some pixels the reference hit its limit of rays before the standard error asked for "
            f"({info['standard_error_asked']:g})."
        )
    return said


def _target_sentence(light: LightResult, target: float) -> str:
    found = budget(light, target)
    if found.record is None:
        return f"No technique stays within the target of {target:g}."
    winner = light.records[found.record]
    tied = _tied([light.records[i].label() for i in found.ties])
    return f"Cheapest within the target of {target:g}: {winner.label()}, {_figures(winner)}{tied}."


def _tied(labels: list[str]) -> str:
    if not labels:
        return ""
    shown = labels if len(labels) <= 3 else [*labels[:2], f"{len(labels) - 2} others"]
    return f"; {' and '.join(shown)} cannot be told from it by time"


def _figures(record: Record) -> str:
    return f"error {record.headline:.3g}, {milliseconds(record.time_ms['dynamic'].median)} a frame"
