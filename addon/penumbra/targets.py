"""When each technique reaches a target error: interpolated between the settings of its sweep. Pure functions.

docs/measuring.md, "Time to an error", derives the interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from .records import LightResult, Mean, Reach, Record, SetTarget, Settings, Target, Value

TARGETS = (0.05, 0.02, 0.01, 0.005)
"""Headline errors that every report tells the time to; `--target-rmse` adds its own."""

_Z = 1.96  # standard errors in half a 95 % interval
_LEAST_MS = 1e-6  # a logarithm has no zero


def errors_asked(target: float | None) -> list[float]:
    """The targets of a report, from coarse to fine."""
    return sorted({*TARGETS, *([target] if target else [])}, reverse=True)


def curve(light: LightResult, technique: str) -> list[int]:
    """Indices of the technique's own Pareto front, from fast to slow; the errors fall strictly."""
    own = [i for i in light.comparable() if light.records[i].technique == technique]
    return staircase(light, own)


def staircase(light: LightResult, indices: Iterable[int]) -> list[int]:
    """Of the indices those that nothing cheaper equals in error, from fast to slow."""
    found: list[int] = []
    for i in sorted(indices, key=lambda i: (_time(light.records[i]), light.records[i].headline)):
        if not found or light.records[i].headline < light.records[found[-1]].headline:
            found.append(i)
    return found


def reach(light: LightResult, technique: str, error: float) -> Reach:
    """When the technique's curve falls to `error`, with a 95 % interval.

    @param technique one that has a comparable record at the light
    """
    indices = curve(light, technique)
    records = [light.records[i] for i in indices]
    made = Reach(technique, records[0].title, "not_reached", closest=records[-1].headline)
    first = next((k for k, record in enumerate(records) if record.headline <= error), None)
    if first is None:
        return made
    made.record = indices[first]
    slower = records[first]
    if first == 0 or not _has_between(records[first - 1], slower):
        spread = slower.time_ms["dynamic"]
        made.state = "at_most" if first == 0 else "reached"
        made.time_ms, made.low_ms, made.high_ms = spread.median, spread.low, spread.high
        made.between = [indices[first]]
        return made
    made.state, made.between = "reached", [indices[first - 1], indices[first]]
    made.time_ms, made.low_ms, made.high_ms = interpolated(_point(records[first - 1]), _point(slower), error)
    made.about = _setting_between(records[first - 1], slower, error)
    return made


def _setting_between(a: Record, b: Record, error: float) -> Settings:
    """The one knob that differs, where the line in log-log meets `error`; empty if several differ."""
    differing = _differing(a, b)
    if len(differing) != 1:
        return {}
    ((name, (x, y)),) = differing.items()
    assert isinstance(x, (int, float)) and isinstance(y, (int, float))
    if min(x, y) <= 0:
        return {}
    share = math.log(a.headline / error) / math.log(a.headline / b.headline)
    value = x * (y / x) ** share
    if isinstance(x, int) and isinstance(y, int):
        return {name: math.ceil(value - 1e-9) if y > x else math.floor(value + 1e-9)}  # rather too good
    return {name: value}


def _differing(a: Record, b: Record) -> dict[str, tuple[Value | None, Value | None]]:
    names = a.settings.keys() | b.settings.keys()
    both = {name: (a.settings.get(name), b.settings.get(name)) for name in sorted(names)}
    return {name: (x, y) for name, (x, y) in both.items() if x != y}


def _has_between(a: Record, b: Record) -> bool:
    """Whether settings between two records exist: they differ in numbers alone, and errors have logarithms."""
    if min(a.headline, b.headline) <= 0.0:
        return False
    return all(_is_number(x) and _is_number(y) for x, y in _differing(a, b).values())


def _is_number(value: Value | None) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


@dataclass(frozen=True)
class Point:
    """A measured setting: median time with its 95 % interval in ms, error with its standard error."""

    time_ms: float
    low_ms: float
    high_ms: float
    error: float
    standard_error: float = 0.0


def _point(record: Record) -> Point:
    spread = record.time_ms["dynamic"]
    return Point(spread.median, spread.low, spread.high, record.headline, record.headline_error)


def interpolated(fast: Point, slow: Point, error: float) -> tuple[float, float, float]:
    """Time, low and high end of its 95 % interval (ms) where the line in log-log from `fast` to `slow` meets `error`.

    With f the share of the way and m = d log t / -d log e, log t = (1 - f) log t1 + f log t2, and its derivatives are
    (1 - f) and f by the two times, m (1 - f) and m f by the two errors: independent uncertainties add as squares.

    @param fast with an error above `error`, @param slow with one of at most `error`, above 0 and slower
    """
    t1, t2 = _log(fast.time_ms), _log(slow.time_ms)
    fall = math.log(fast.error / slow.error)
    f = math.log(fast.error / error) / fall
    time, m = t1 + f * (t2 - t1), (t2 - t1) / fall
    of_errors = [
        _Z * m * (1 - f) * fast.standard_error / fast.error,
        _Z * m * f * slow.standard_error / slow.error,
    ]
    down = math.hypot((1 - f) * (t1 - _log(fast.low_ms)), f * (t2 - _log(slow.low_ms)), *of_errors)
    up = math.hypot((1 - f) * (_log(fast.high_ms) - t1), f * (_log(slow.high_ms) - t2), *of_errors)
    return math.exp(time), math.exp(time - down), math.exp(time + up)


def _log(time_ms: float) -> float:
    return math.log(max(time_ms, _LEAST_MS))


def _time(record: Record) -> float:
    return record.time_ms["dynamic"].median


def target(light: LightResult, error: float) -> Target:
    """All techniques of the light, the winner, and those that the intervals cannot tell from it."""
    names = dict.fromkeys(light.records[i].technique for i in light.comparable())
    reaches = [reach(light, technique, error) for technique in names]
    there = [each for each in reaches if each.time_ms is not None]
    if not there:
        return Target(error, None, [], reaches)
    winner = min(there, key=lambda each: each.time_ms or 0.0)
    ties = [each.technique for each in there if each is not winner and _overlap(each, winner)]
    return Target(error, winner.technique, ties, reaches)


def _overlap(a: Reach, b: Reach) -> bool:
    assert a.low_ms is not None and b.low_ms is not None and a.high_ms is not None and b.high_ms is not None
    return a.low_ms <= b.high_ms and b.low_ms <= a.high_ms


def over_scenes(scenes: Sequence[Sequence[Target]]) -> list[SetTarget]:
    """Geometric means over a set of scenes, from each scene's targets (of one list of errors).

    The ratio is a technique's time over that of the scene's fastest, so that no scene weighs more for being slow. A
    technique that misses the target in a scene has its mean over the others, and stands behind those that reach it in
    more scenes.
    """
    found = []
    for column in zip(*scenes, strict=True):
        names: dict[str, str] = {}
        for each in column:
            names |= {r.technique: r.title for r in each.reaches}
        means = [_mean(column, technique, title) for technique, title in names.items()]
        means.sort(key=lambda mean: (-mean.scenes, mean.ratio if mean.ratio is not None else math.inf))
        winner = means[0].technique if means and means[0].scenes else None
        found.append(SetTarget(column[0].error, len(column), winner, means))
    return found


def _mean(column: Sequence[Target], technique: str, title: str) -> Mean:
    logs: list[tuple[float, float, float]] = []
    at_most = False
    for each in column:
        by_name = {r.technique: r for r in each.reaches if r.time_ms is not None}
        if technique not in by_name or each.winner is None:
            continue
        own, best = by_name[technique], by_name[each.winner]
        at_most = at_most or own.state == "at_most"
        logs.append(_log_ratio(own, best))
    if not logs:
        return Mean(technique, title, 0)
    n = len(logs)
    middle = sum(log for log, _, _ in logs) / n
    down, up = (math.hypot(*(ends[k] for ends in logs)) / n for k in (1, 2))
    return Mean(technique, title, n, math.exp(middle), math.exp(middle - down), math.exp(middle + up), at_most)


def _log_ratio(own: Reach, best: Reach) -> tuple[float, float, float]:
    """Logarithm of own over best, and how far its interval goes down and up; of a winner exactly 0."""
    if own is best:
        return 0.0, 0.0, 0.0
    assert own.time_ms and own.low_ms and own.high_ms and best.time_ms and best.low_ms and best.high_ms
    down = math.hypot(_log(own.time_ms) - _log(own.low_ms), _log(best.high_ms) - _log(best.time_ms))
    up = math.hypot(_log(own.high_ms) - _log(own.time_ms), _log(best.time_ms) - _log(best.low_ms))
    return _log(own.time_ms) - _log(best.time_ms), down, up
