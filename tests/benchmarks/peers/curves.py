"""Error against time: the staircase of a renderer's points, and when it reaches a target."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from penumbra.targets import Point, interpolated


@dataclass(frozen=True)
class Sample:
    """One measured setting."""

    error: float
    time_ms: float
    label: str = ""


def staircase(samples: Iterable[Sample]) -> list[Sample]:
    """Those that none cheaper equals in error, from fast to slow."""
    kept: list[Sample] = []
    for sample in sorted(samples, key=lambda each: (each.time_ms, each.error)):
        if not kept or sample.error < kept[-1].error:
            kept.append(sample)
    return kept


def time_to(target: float, samples: Iterable[Sample]) -> float | None:
    """When the staircase falls to the target, interpolated in logarithms; None if it never does.

    A first point that is good enough already counts as it is: nothing is known of less.
    """
    steps = staircase(samples)
    there = next((i for i, step in enumerate(steps) if step.error <= target), None)
    if there is None:
        return None
    slow = steps[there]
    if there == 0 or slow.error <= 0.0:
        return slow.time_ms
    fast, slow_point = (Point(s.time_ms, s.time_ms, s.time_ms, s.error) for s in (steps[there - 1], slow))
    return interpolated(fast, slow_point, target)[0]


def cheapest(target: float, samples: Iterable[Sample]) -> Sample | None:
    """The fastest measured setting that is good enough."""
    return next((step for step in staircase(samples) if step.error <= target), None)
