"""Several lights as one: the settings that were measured at all of them. Pure functions.

A scene's lights are rendered in one frame with one set of settings: their times add up, and the largest of their errors
counts. Over a set of scenes the times are geometric means, so that one technique's over another's is the geometric mean
of their ratios, and no scene weighs more for being slow.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from typing import Any

from . import targets, verdict
from .records import Comparison, LightResult, Record, SceneResult, Spread, headline

_LEAST_MS = 1e-6  # a logarithm has no zero
_ERRORS = ("rmse", "leak", "over_darkening")

Frames = Callable[[Sequence[Spread]], Spread]
"""One time for several: added() or geometric_mean()."""


def summarise(comparison: Comparison, target: float | None) -> None:
    """Fills in what the comparison says of each scene with several lights, and of several scenes."""
    wholes = []
    for scene in comparison.scenes:
        scene.together = _judged(_lights(scene), f"{scene.name}: all lights", added, target)
        whole = scene.together or next(iter(_lights(scene)), None)
        if whole is not None:
            wholes.append(whole)
    if len(wholes) < 2:
        return
    comparison.together = _judged(wholes, "All scenes", geometric_mean, target)
    errors = targets.errors_asked(target)
    comparison.targets = targets.over_scenes([[targets.target(whole, error) for error in errors] for whole in wholes])


def _lights(scene: SceneResult) -> list[LightResult]:
    """Those at which anything was measured."""
    return [light for light in scene.lights if light.comparable()]


def _judged(lights: Sequence[LightResult], name: str, mean: Frames, target: float | None) -> LightResult | None:
    if len(lights) < 2:
        return None
    made = combine(lights, name, mean)

    def front(times: Sequence[float], errors: Sequence[float]) -> list[bool]:
        on_it = set(targets.staircase(made, range(len(times))))
        return [i in on_it for i in range(len(errors))]

    verdict.judge(made, target, front)
    absent = _absent(lights, made)
    if absent:
        made.sentences.append(f"Not measured everywhere, and so not here: {', '.join(absent)}.")
    return made


def combine(lights: Sequence[LightResult], name: str, mean: Frames) -> LightResult:
    """One record for each technique and settings that all lights have a figure of: largest errors, times by `mean`."""
    tables = [{key_of(light.records[i]): light.records[i] for i in light.comparable()} for light in lights]
    shared = [key for key in tables[0] if all(key in table for table in tables)]
    return LightResult(name, "", [], records=[_combined([table[key] for table in tables], mean) for key in shared])


def key_of(record: Record) -> tuple[str, str]:
    """Technique and settings: what makes two records of two lights the same choice."""
    return record.technique, json.dumps(record.settings, sort_keys=True)


def _absent(lights: Sequence[LightResult], made: LightResult) -> list[str]:
    titles = {record.technique: record.title for light in lights for record in light.records}
    return [title for technique, title in titles.items() if all(r.technique != technique for r in made.records)]


def _combined(records: Sequence[Record], mean: Frames) -> Record:
    first = records[0]
    worst = max(records, key=lambda record: record.headline)
    flips = [record.flip for record in records if record.flip is not None]
    names = [name for name in first.time_ms if all(name in record.time_ms for record in records)]
    return Record(
        first.technique,
        first.title,
        dict(first.settings),
        seeds=min(record.seeds for record in records),
        sweep=first.sweep,
        given=dict(first.given),
        area=_largest([record.area or {} for record in records]),
        irradiance=_largest([record.irradiance or {} for record in records]),
        flip=max(flips, default=None),
        headline_error=worst.headline_error,
        time_ms={name: mean([record.time_ms[name] for record in records]) for name in names},
        memory_bytes=max(record.memory_bytes for record in records),
    )


def _largest(errors: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of each figure the largest; the headline of each light, whichever it was, becomes the penumbra RMSE."""
    found = {name: max(float(each.get(name, 0.0)) for each in errors) for name in _ERRORS}
    return found | {"penumbra_rmse": max(headline(each) for each in errors), "penumbra_pixels": 1, "pixels": 1}


def added(spreads: Sequence[Spread]) -> Spread:
    """Of one frame that does all: independent uncertainties add as squares."""
    median = math.fsum(spread.median for spread in spreads)
    return Spread(
        median,
        math.fsum(spread.p10 for spread in spreads),
        math.fsum(spread.p90 for spread in spreads),
        median - math.hypot(*(spread.median - spread.low for spread in spreads)),
        median + math.hypot(*(spread.high - spread.median for spread in spreads)),
        min(spread.runs for spread in spreads),
        _all_tight(spreads),
    )


def geometric_mean(spreads: Sequence[Spread]) -> Spread:
    """With an interval from the intervals' ends, as squares of logarithms."""
    n = len(spreads)
    median = math.fsum(_log(spread.median) for spread in spreads) / n
    return Spread(
        math.exp(median),
        math.exp(math.fsum(_log(spread.p10) for spread in spreads) / n),
        math.exp(math.fsum(_log(spread.p90) for spread in spreads) / n),
        math.exp(median - math.hypot(*(_log(spread.median) - _log(spread.low) for spread in spreads)) / n),
        math.exp(median + math.hypot(*(_log(spread.high) - _log(spread.median) for spread in spreads)) / n),
        min(spread.runs for spread in spreads),
        _all_tight(spreads),
    )


def _log(time_ms: float) -> float:
    return math.log(max(time_ms, _LEAST_MS))


def _all_tight(spreads: Sequence[Spread]) -> bool | None:
    told = [spread.tight for spread in spreads]
    return None if None in told else all(told)
