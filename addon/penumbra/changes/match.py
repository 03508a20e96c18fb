"""Which records of two reports belong together, and what changed between them. Pure functions.

A change of an error or a time is called one only if the two 95 % intervals do not overlap. By chance two equal
quantities do so about once in 180 pairs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath, PureWindowsPath
from typing import Any, Literal, TypeVar

from ..records import LightResult, Record, SceneResult, Spread, Step
from ..verdict import FEWEST_RUNS
from .read import Report

Call = Literal["same", "less", "more", "unknown"]
"""less: faster, or more accurate; unknown: too few runs to tell."""

FRAMES = ("dynamic", "static")
_Z = 1.96
_ROUNDING = 1e-6  # of V: what two compilers' arithmetic differs by
_LEAST_MS = 1e-6  # a ratio has no zero

_UNTOLD = ("date", "command")  # differ always, and change nothing


@dataclass(frozen=True)
class Ratio:
    """Of B to A, with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class TimeChange:
    frame: str  # dynamic, static
    a_ms: float
    b_ms: float
    ratio: Ratio
    call: Call


@dataclass(frozen=True)
class ErrorChange:
    """Of the headline error; `a` and `b` with 1.96 standard errors either side."""

    a: float
    b: float
    a_width: float
    b_width: float
    call: Call


@dataclass(frozen=True)
class StepChange:
    """A step of the plan: "run", "left out", or "" where there is none."""

    step: str
    a: str
    b: str
    reason: str


@dataclass(frozen=True)
class Pair:
    """One technique with one set of settings at one light, in both reports."""

    technique: str
    title: str
    label: str
    settings: dict[str, Any]
    changed: dict[str, Any]  # by the sweep
    a_status: str
    b_status: str
    reason: str  # of the one that is not ok
    error: ErrorChange | None = None
    times: tuple[TimeChange, ...] = ()
    plan: tuple[StepChange, ...] = ()
    a_memory: int = 0
    b_memory: int = 0
    new_settings: tuple[str, ...] = ()  # that one of the versions does not have

    @property
    def changes(self) -> bool:
        calls = [time.call for time in self.times] + ([self.error.call] if self.error else [])
        return self.a_status != self.b_status or bool(self.plan) or any(call in ("less", "more") for call in calls)

    def time(self, frame: str) -> TimeChange | None:
        return next((time for time in self.times if time.frame == frame), None)


@dataclass
class LightChanges:
    name: str
    shape: str
    pairs: list[Pair] = field(default_factory=list)
    only_a: list[str] = field(default_factory=list)
    only_b: list[str] = field(default_factory=list)


@dataclass
class SceneChanges:
    name: str
    camera: str
    frame: int
    notes: list[str] = field(default_factory=list)
    compared: bool = True  # False: another size of picture
    lights: list[LightChanges] = field(default_factory=list)
    only_a: list[str] = field(default_factory=list)  # lights
    only_b: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class TechniqueChanges:
    """Geometric means over all pairs of one technique, sweep steps included."""

    technique: str
    title: str
    pairs: int
    time: Ratio | None  # dynamic frame
    error: float | None  # of pairs with an error above zero on both sides
    faster: int
    slower: int
    better: int
    worse: int


@dataclass
class Changes:
    a: Report
    b: Report
    environment: list[tuple[str, str, str]]  # what differs
    options: list[tuple[str, str, str]]
    scenes: list[SceneChanges]
    only_a: list[str]  # scenes
    only_b: list[str]
    techniques: list[TechniqueChanges]
    overall: Ratio | None  # of all pairs' dynamic frames: what the machine changes

    def pairs(self) -> Iterable[tuple[SceneChanges, LightChanges, Pair]]:
        for scene in self.scenes:
            for light in scene.lights:
                for pair in light.pairs:
                    yield scene, light, pair

    @property
    def missing(self) -> list[str]:
        """What is in one report alone."""
        found = [f"{name} only in A" for name in self.only_a] + [f"{name} only in B" for name in self.only_b]
        for scene in self.scenes:
            found += [f"{scene.name}: {name} only in A" for name in scene.only_a]
            found += [f"{scene.name}: {name} only in B" for name in scene.only_b]
            for light in scene.lights:
                found += [f"{scene.name}, {light.name}: {label} only in A" for label in light.only_a]
                found += [f"{scene.name}, {light.name}: {label} only in B" for label in light.only_b]
        return found


def changes(a: Report, b: Report) -> Changes:
    """Everything that changed from A to B."""
    scenes, only_a, only_b = _paired(a.comparison.scenes, b.comparison.scenes, _scene_key)
    made = Changes(
        a,
        b,
        _differences(_flat(a.environment), _flat(b.environment)),
        _differences(a.comparison.options, b.comparison.options),
        [_scene(x, y) for x, y in scenes],
        [_scene_name(scene) for scene in only_a],
        [_scene_name(scene) for scene in only_b],
        [],
        None,
    )
    pairs = [pair for _, _, pair in made.pairs()]
    made.techniques = [
        _technique([pair for pair in pairs if pair.technique == technique])
        for technique in dict.fromkeys(pair.technique for pair in pairs)
    ]
    made.overall = _mean(pairs)
    return made


T = TypeVar("T")


def _paired(a: Sequence[T], b: Sequence[T], key: Callable[[T], Any]) -> tuple[list[tuple[T, T]], list[T], list[T]]:
    """Those of one key in both, the first with the first, the second with the second; and the rest of either."""
    left = list(b)
    pairs, only_a = [], []
    for each in a:
        found = next((other for other in left if key(other) == key(each)), None)
        if found is None:
            only_a.append(each)
        else:
            left = [other for other in left if other is not found]
            pairs.append((each, found))
    return pairs, only_a, left


def _scene_key(scene: SceneResult) -> tuple[str, str, int]:
    """The file's name: folders differ between machines."""
    return _file(scene.path), scene.camera, scene.frame


def _file(path: str) -> str:
    return PureWindowsPath(path).name if "\\" in path else PurePath(path).name


def _scene_name(scene: SceneResult) -> str:
    return f"{_file(scene.path)} (camera {scene.camera}, frame {scene.frame})"


def _scene(a: SceneResult, b: SceneResult) -> SceneChanges:
    made = SceneChanges(PurePath(_file(a.path)).stem, a.camera, a.frame)
    if a.size != b.size:
        made.compared = False
        made.notes.append(
            f"the pictures are {a.size[0]} x {a.size[1]} in A and {b.size[0]} x {b.size[1]} in B: nothing is compared"
        )
        return made
    if a.triangles != b.triangles:
        made.notes.append(f"the scene itself differs: {a.triangles:,} triangles in A, {b.triangles:,} in B")
    lights, only_a, only_b = _paired(a.lights, b.lights, lambda light: light.name)
    made.only_a, made.only_b = [light.name for light in only_a], [light.name for light in only_b]
    for x, y in lights:
        if (x.shape, x.size_m, x.angle_rad) != (y.shape, y.size_m, y.angle_rad):
            made.notes.append(f"the light {x.name} differs in shape or size")
        made.lights.append(_light(x, y))
    return made


def _light(a: LightResult, b: LightResult) -> LightChanges:
    made = LightChanges(a.name, a.shape)
    left = list(b.records)
    for record in a.records:
        found = next((other for other in left if _same_choice(record, other)), None)
        if found is None:
            made.only_a.append(record.label())
            continue
        left = [other for other in left if other is not found]
        made.pairs.append(_pair(record, found))
    made.only_b = [record.label() for record in left]
    return made


def _same_choice(a: Record, b: Record) -> bool:
    """One technique with equal settings. One that a version lacks is no difference, unless a sweep changed it."""
    if a.technique != b.technique:
        return False
    if a.status != "ok" or b.status != "ok":  # only what was measured tells all its settings
        return a.changed == b.changed
    if a.changed.keys() - b.settings.keys() or b.changed.keys() - a.settings.keys():
        return False
    return all(_equal(a.settings[name], b.settings[name]) for name in a.settings.keys() & b.settings.keys())


def _equal(a: Any, b: Any) -> bool:
    return isinstance(a, bool) is isinstance(b, bool) and bool(a == b)


def _pair(a: Record, b: Record) -> Pair:
    both = a.status == b.status == "ok"
    frames = [name for name in FRAMES if both and name in a.time_ms and name in b.time_ms]
    known = both and math.isfinite(a.headline) and math.isfinite(b.headline)
    return Pair(
        a.technique,
        b.title,
        b.label() if b.status == "ok" else a.label(),
        dict(b.settings),
        b.changed,
        a.status,
        b.status,
        b.reason or a.reason,
        error_change(a, b) if known else None,
        tuple(time_change(name, a.time_ms[name], b.time_ms[name]) for name in frames),
        tuple(plan_changes(a.plan, b.plan)) if both else (),
        a.memory_bytes,
        b.memory_bytes,
        tuple(sorted(a.settings.keys() ^ b.settings.keys())) if both else (),
    )


def error_change(a: Record, b: Record) -> ErrorChange:
    wide_a, wide_b = _Z * _standard_error(a), _Z * _standard_error(b)
    difference = b.headline - a.headline
    call: Call = "same"
    if abs(difference) > max(wide_a + wide_b, _ROUNDING):
        call = "more" if difference > 0 else "less"
    return ErrorChange(a.headline, b.headline, wide_a, wide_b, call)


def _standard_error(record: Record) -> float:
    """Reports from before it was kept tell the reference's noise, whose square stands in the mean square error."""
    if record.headline_error > 0.0:
        return record.headline_error
    noise = float((record.area or {}).get("reference_standard_error", 0.0))
    return min(noise, noise * noise / (2.0 * record.headline)) if record.headline > 0.0 else noise


def time_change(frame: str, a: Spread, b: Spread) -> TimeChange:
    """The interval of the ratio goes from the least to the most that the two intervals allow."""

    def over(x: float, y: float) -> float:
        return max(x, _LEAST_MS) / max(y, _LEAST_MS)

    ratio = Ratio(over(b.median, a.median), over(b.low, a.high), over(b.high, a.low))
    call: Call = "more" if b.low > a.high else "less" if b.high < a.low else "same"
    if min(a.runs, b.runs) < FEWEST_RUNS:
        call = "unknown"
    return TimeChange(frame, a.median, b.median, ratio, call)


def plan_changes(a: Sequence[Step], b: Sequence[Step]) -> list[StepChange]:
    """Steps that are run in one and not in the other."""
    pairs, only_a, only_b = _paired(a, b, lambda step: step.step)
    found = [StepChange(x.step, _state(x), _state(y), y.reason or x.reason) for x, y in pairs if _state(x) != _state(y)]
    found += [StepChange(x.step, _state(x), "", x.reason) for x in only_a]
    return found + [StepChange(y.step, "", _state(y), y.reason) for y in only_b]


def _state(step: Step) -> str:
    return "run" if step.state == "run" else "left out"


def _technique(pairs: Sequence[Pair]) -> TechniqueChanges:
    errors = [pair.error for pair in pairs if pair.error is not None]
    above = [math.log(error.b / error.a) for error in errors if error.a > 0.0 and error.b > 0.0]
    calls = [time.call for pair in pairs if (time := pair.time("dynamic")) is not None]
    return TechniqueChanges(
        pairs[0].technique,
        pairs[0].title,
        len(pairs),
        _mean(pairs),
        math.exp(math.fsum(above) / len(above)) if above else None,
        calls.count("less"),
        calls.count("more"),
        sum(error.call == "less" for error in errors),
        sum(error.call == "more" for error in errors),
    )


def _mean(pairs: Sequence[Pair]) -> Ratio | None:
    """Geometric mean of the dynamic frames' ratios that are known; their intervals add as squares of logarithms."""
    times = [time for pair in pairs if (time := pair.time("dynamic")) is not None]
    ratios = [time.ratio for time in times if time.call != "unknown"]
    if not ratios:
        return None
    n = len(ratios)
    middle = math.fsum(math.log(ratio.value) for ratio in ratios) / n
    down = math.hypot(*(math.log(ratio.value / ratio.low) for ratio in ratios)) / n
    up = math.hypot(*(math.log(ratio.high / ratio.value) for ratio in ratios)) / n
    return Ratio(math.exp(middle), math.exp(middle - down), math.exp(middle + up))


def _flat(environment: dict[str, Any]) -> dict[str, Any]:
    build = environment.get("build")
    inner = {f"build {key}": value for key, value in build.items()} if isinstance(build, dict) else {}
    return {key: value for key, value in environment.items() if key not in (*_UNTOLD, "build")} | inner


def _differences(a: dict[str, Any], b: dict[str, Any]) -> list[tuple[str, str, str]]:
    return [
        (name, _word(a.get(name)), _word(b.get(name))) for name in dict.fromkeys([*a, *b]) if a.get(name) != b.get(name)
    ]


def _word(value: Any) -> str:
    if value is None or value == "":
        return "–"
    return ("yes" if value else "no") if isinstance(value, bool) else str(value)
