"""What is measured: every renderer's settings, and how long each may take."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

OURS = "ours"


@dataclass(frozen=True)
class Point:
    """One setting of one renderer, or of one of our techniques."""

    worker: str  # the process that renders it
    curve: str  # the curve it lies on: a renderer's, or a technique's id
    label: str
    settings: dict[str, Any] = field(default_factory=dict, compare=False)

    @property
    def id(self) -> str:
        text = f"{self.worker} {self.curve} {self.label}"
        return "".join(c if c.isalnum() or c in "._-" else "_" for c in text)


@dataclass(frozen=True)
class Curve:
    """A way to render; `group` says which of the issue's targets it counts for."""

    id: str
    title: str
    group: str  # "blender", "mitsuba", "embree"
    worker: str
    samples: tuple[int, ...]
    quick: tuple[int, ...]
    settings: dict[str, Any] = field(default_factory=dict)

    def points(self, sweep: str) -> list[Point]:
        return [
            Point(self.worker, self.id, f"{n} samples", self.settings | {"samples": n})
            for n in (self.samples if sweep == "full" else self.quick)
        ]


CURVES = (
    Curve("cycles", "Cycles", "blender", "cycles", (1, 2, 4, 8, 16, 32, 64, 128), (1, 4, 16, 64)),
    Curve(
        "cycles_oidn_fast",
        "Cycles, OIDN fast",
        "blender",
        "cycles",
        (1, 2, 4, 8, 16, 32, 64),
        (1, 4, 16),
        {"denoise": ("FAST", "FAST")},
    ),
    Curve(
        "cycles_oidn_high",
        "Cycles, OIDN high",
        "blender",
        "cycles",
        (1, 2, 4, 8, 16, 32, 64),
        (1, 4, 16),
        {"denoise": ("HIGH", "ACCURATE")},
    ),
    Curve("eevee", "EEVEE", "blender", "eevee", (1, 4, 16, 64), (1, 4), {"jitter": False}),
    Curve("eevee_jitter", "EEVEE, shadow jitter", "blender", "eevee", (1, 4, 16, 64), (1, 4), {"jitter": True}),
    Curve("mitsuba", "Mitsuba 3", "mitsuba", "mitsuba", (1, 2, 4, 8, 16, 32, 64, 128, 256), (1, 4, 16, 64, 256)),
    Curve("embree", "bare Embree", "embree", "embree", (1, 2, 4, 8, 16, 32, 64, 128, 256, 512), (1, 4, 16, 64, 256)),
)


@dataclass(frozen=True)
class Limits:
    """When a point has been measured enough."""

    point_s: float  # spent on a point, warm-up and pictures included
    min_runs: int  # of a point that takes less of it
    max_runs: int
    tight: float = 0.05  # the median's interval, of the median
    ours_s: float = 1.0  # for one call of the core's measuring
    dearest_s: float = 10.0  # settings of ours that take longer are left out with all dearer ones of their technique


LIMITS = {
    "quick": Limits(point_s=1.0, min_runs=3, max_runs=5, ours_s=0.3, dearest_s=0.5),
    "full": Limits(point_s=15.0, min_runs=5, max_runs=25),
}
