"""What a run finds, as plain data: a row for each technique, case and property (stability.json)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

SCHEMA = 1

Outcome = Literal["holds", "bounded", "known_limit", "violated"]
OUTCOMES: tuple[Outcome, ...] = ("holds", "bounded", "known_limit", "violated")
"""From good to bad."""


@dataclass(frozen=True)
class Measured:
    """A figure before it is judged."""

    property: str
    value: float
    bound: float  # up to here the property holds
    forms: Mapping[str, float] = field(default_factory=dict)  # up to here by each closed form that a limit names


@dataclass(frozen=True)
class Row:
    technique: str
    case: str
    property: str
    value: float | None  # None: there is none, because the process crashed
    bound: float  # the one that the outcome refers to
    outcome: Outcome
    reason: str = ""  # empty where it holds

    def to_json(self) -> dict[str, Any]:
        return {
            "technique": self.technique,
            "case": self.case,
            "property": self.property,
            "value": _number(self.value),
            "bound": _number(self.bound),
            "outcome": self.outcome,
            "reason": self.reason,
        }


def worst(rows: Sequence[Row]) -> Outcome:
    return max((row.outcome for row in rows), key=OUTCOMES.index, default="holds")


def _number(value: float | None) -> float | None:
    """JSON knows no infinity."""
    if value is None or math.isnan(value):
        return None
    return max(-1e308, min(1e308, value))
