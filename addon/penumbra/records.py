"""What a comparison finds out, as plain data, and the JSON it is kept in (docs/measuring.md defines every figure)."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

SCHEMA = 1

Image = npt.NDArray[np.float32]
"""(height, width) or (height, width, channels) float32; row 0 is the bottom row."""

Mask = npt.NDArray[np.uint8]

Value = bool | int | float | str
Settings = dict[str, Value]
Status = Literal["ok", "unsupported", "failed"]

ERROR_FIELDS = ("rmse", "mae", "bias", "p95", "p99", "max", "penumbra_rmse")
PART_FIELDS = ("noise", "leak", "over_darkening", "bias", "aliasing")


@dataclass(slots=True)
class Spread:
    """Repeated times in milliseconds: the median, its 95 % interval, and the tenth and ninetieth percentile."""

    median: float
    p10: float
    p90: float
    low: float
    high: float
    runs: int
    tight: bool | None = None  # measured until the interval was narrow enough; None: not told (measured once, old file)


@dataclass(slots=True)
class Step:
    step: str
    state: Literal["run", "left_out"]
    reason: str = ""
    rule: str = ""
    tolerance: float = 0.0
    time_ms: float = 0.0


@dataclass(slots=True)
class Statistic:
    """A count or share that the technique reports of its frame."""

    id: str
    label: str
    unit: str
    value: float

    def text(self) -> str:
        """Shares in percent, counts with their thousands apart, other numbers to three digits."""
        if not math.isfinite(self.value):
            return "–"
        if self.unit.startswith("share"):
            return f"{100.0 * self.value:.3g} % {self.unit.removeprefix('share').strip()}".strip()
        text = f"{self.value:,.0f}" if float(self.value).is_integer() else f"{self.value:.3g}"
        return f"{text} {self.unit}".strip()


@dataclass(slots=True)
class Record:
    """One technique with one set of settings at one light."""

    technique: str
    title: str
    settings: Settings
    status: Status = "ok"
    reason: str = ""
    seeds: int = 1
    sweep: dict[str, Any] | None = None  # of a sweep step (sweep.entry), None for what was asked for
    given: Settings = field(default_factory=dict)  # those of `settings` that were asked for, not left at their defaults
    area: dict[str, Any] | None = None  # core.measure_errors against the reference's `area`
    irradiance: dict[str, Any] | None = None
    flip: float | None = None
    headline_error: float = 0.0  # standard error of `headline`
    time_ms: dict[str, Spread] = field(default_factory=dict)  # setup, dynamic, static, kept, view
    everything_ms: dict[str, Spread] = field(default_factory=dict)  # dynamic, static: nothing left out, if measured
    memory_bytes: int = 0
    plan: list[Step] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)  # where the technique leaves its field of use
    statistics: list[Statistic] = field(default_factory=list)
    images: dict[str, str] = field(default_factory=dict)
    on_pareto_front: bool = False
    on_own_front: bool = False  # of its technique alone: the technique's curve
    visibility: Image | None = None  # dropped once the images are written

    @property
    def is_sweep_step(self) -> bool:
        return self.sweep is not None

    @property
    def headline(self) -> float:
        """Penumbra RMSE against `area`, or the RMSE over the mask where the reference has no penumbra."""
        return headline(self.area)

    @property
    def changed(self) -> Settings:
        """What a sweep step changes; empty for what was asked for."""
        if self.sweep is None:
            return {}
        # Before steps of several settings there was no "changed".
        return dict(self.sweep.get("changed") or {self.sweep["setting"]: self.sweep["value"]})

    def saved_ms(self, frame: str = "dynamic") -> float | None:
        """What the rules saved of a frame: medians of one interleaved run. None if it was not measured."""
        if frame not in self.everything_ms or frame not in self.time_ms:
            return None
        return self.everything_ms[frame].median - self.time_ms[frame].median

    def label(self) -> str:
        """The title, with the changed settings if this is a step of a sweep."""
        return f"{self.title} ({settings_text(self.changed)})" if self.changed else self.title


def settings_text(settings: Settings) -> str:
    """ "map_size 2048, mask on" """
    return ", ".join(f"{key} {_shown(value)}" for key, value in settings.items())


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)


def word(value: Value) -> str:
    """As --set takes it."""
    return ("on" if value else "off") if isinstance(value, bool) else str(value)


def headline(errors: dict[str, Any] | None) -> float:
    if errors is None:
        return math.nan
    return float(errors["penumbra_rmse"] if errors.get("penumbra_pixels", 1) else errors["rmse"])


@dataclass(slots=True)
class ReferenceResult:
    """The truth for one light, and what it cost."""

    method: str
    area: Image
    irradiance: Image
    standard_error: Image
    irradiance_standard_error: Image
    mask: Mask
    rays: int
    mean_rays_per_pixel: float
    standard_error_asked: float
    time_ms: float
    reached: bool
    pixels_skipped: int
    from_cache: bool = False


@dataclass(slots=True)
class Budget:
    """The cheapest record whose headline error stays within `error`, and those that its timing cannot be told from."""

    error: float
    technique: str | None
    record: int | None  # index into the light's records
    ties: list[int] = field(default_factory=list)


@dataclass(slots=True)
class Reach:
    """When the headline error of one technique falls to a target: on its own curve, in time of a dynamic frame."""

    technique: str
    title: str
    state: Literal["reached", "at_most", "not_reached"]  # at_most: its fastest setting is within the target already
    time_ms: float | None = None  # reached: between two settings; at_most: of the fastest one
    low_ms: float | None = None  # 95 % interval
    high_ms: float | None = None
    between: list[int] = field(default_factory=list)  # records that the time is interpolated between; one: its own
    record: int | None = None  # its cheapest record within the target: measured, and so sure
    about: Settings = field(default_factory=dict)  # of interpolated times: the knob's value there, if one knob differs
    closest: float | None = None  # its smallest error


@dataclass(slots=True)
class Target:
    """Who reaches an error first."""

    error: float
    winner: str | None
    ties: list[str] = field(default_factory=list)  # techniques whose intervals overlap the winner's
    reaches: list[Reach] = field(default_factory=list)


@dataclass(slots=True)
class Saving:
    """Share of another record's time that the pick saves; negative: it takes longer."""

    against: Literal["default", "next_best"]
    technique: str
    record: int
    share: float
    low: float  # 95 % interval
    high: float


@dataclass(slots=True)
class Pick:
    """The cheapest measured setting within the target, what it is worth, and how to ask for it."""

    error: float
    technique: str
    record: int
    arguments: list[str]  # of the command line
    savings: list[Saving]
    sentence: str


@dataclass(slots=True)
class LightResult:
    name: str
    shape: str
    size_m: list[float]
    summary: dict[str, Any] = field(default_factory=dict)
    reference: ReferenceResult | None = None
    reference_info: dict[str, Any] = field(default_factory=dict)
    records: list[Record] = field(default_factory=list)
    budgets: list[Budget] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    cheapest_within_target: str | None = None
    cheapest_settings: Settings | None = None
    pick: Pick | None = None
    targets: list[Target] = field(default_factory=list)
    angle_rad: float | None = None  # suns have an angle instead of a size
    irradiance: Image | None = None  # (h, w, 3) unshadowed, W/m^2

    def comparable(self) -> list[int]:
        """Indices of the records that have an error and a time."""
        return [
            i
            for i, record in enumerate(self.records)
            if record.status == "ok" and math.isfinite(record.headline) and "dynamic" in record.time_ms
        ]


@dataclass(slots=True)
class SceneResult:
    path: str
    camera: str
    frame: int
    size: tuple[int, int]
    triangles: int
    summary: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    lights: list[LightResult] = field(default_factory=list)
    together: LightResult | None = None  # of several lights: settings that were measured at all of them (together.py)
    albedo: Image | None = None
    hit: Mask | None = None  # 1 where the camera sees anything

    @property
    def name(self) -> str:
        return Path(self.path).stem


@dataclass(slots=True)
class Failure:
    """What was asked for and could not be delivered; the rest was."""

    what: str
    reason: str


@dataclass(slots=True)
class Mean:
    """One technique over a set of scenes: geometric mean of its time to the target over each scene's fastest."""

    technique: str
    title: str
    scenes: int  # that it reaches the target in; the mean is over those
    ratio: float | None = None
    low: float | None = None  # 95 % interval
    high: float | None = None
    at_most: bool = False  # in a scene its fastest setting is within the target already


@dataclass(slots=True)
class SetTarget:
    """Who reaches an error first over a set of scenes: in the most scenes, and of those with the least mean ratio."""

    error: float
    scenes: int
    winner: str | None
    means: list[Mean] = field(default_factory=list)


@dataclass(slots=True)
class Comparison:
    environment: dict[str, Any]
    options: dict[str, Any] = field(default_factory=dict)
    scenes: list[SceneResult] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    together: LightResult | None = None  # of several scenes: geometric mean times of settings measured in all of them
    targets: list[SetTarget] = field(default_factory=list)


def to_json(comparison: Comparison) -> dict[str, Any]:
    """The content of report.json: schema 1 of the design, plus fields of ours that a reader may ignore."""
    document = {
        "schema": SCHEMA,
        "environment": comparison.environment,
        "options": comparison.options,
        "failures": [asdict(failure) for failure in comparison.failures],
        "scenes": [_scene(scene) for scene in comparison.scenes],
        "together": _together(comparison.together),
        "targets": [asdict(target) for target in comparison.targets],
    }
    return _plain(document)  # type: ignore[no-any-return]


def _scene(scene: SceneResult) -> dict[str, Any]:
    return {
        "path": scene.path,
        "camera": scene.camera,
        "frame": scene.frame,
        "size": list(scene.size),
        "triangles": scene.triangles,
        "summary": scene.summary,
        "notes": scene.notes,
        "lights": [_light(light) for light in scene.lights],
        "together": _together(scene.together),
    }


def _light(light: LightResult) -> dict[str, Any]:
    document: dict[str, Any] = {
        "name": light.name,
        "shape": light.shape,
        "size_m": light.size_m,
        "summary": light.summary,
        "reference": light.reference_info,
        "sentences": light.sentences,
        "records": [_record(record) for record in light.records],
        "budgets": [asdict(budget) for budget in light.budgets],
        "cheapest_within_target": light.cheapest_within_target,
        "cheapest_settings": light.cheapest_settings,
        "pick": asdict(light.pick) if light.pick is not None else None,
        "targets": [asdict(target) for target in light.targets],
    }
    if light.angle_rad is not None:
        document["angle_rad"] = light.angle_rad
    return document


def _together(light: LightResult | None) -> dict[str, Any] | None:
    """The figures of several lights at once; there is no reference and no picture of them."""
    if light is None:
        return None
    records = [
        {
            "technique": record.technique,
            "title": record.title,
            "settings": record.settings,
            "sweep": record.sweep,
            "given": record.given,
            "headline": record.headline,
            "headline_error": record.headline_error,
            "time_ms": {name: asdict(spread) for name, spread in record.time_ms.items()},
            "on_pareto_front": record.on_pareto_front,
            "on_own_front": record.on_own_front,
        }
        for record in light.records
    ]
    return {
        "name": light.name,
        "sentences": light.sentences,
        "records": records,
        "pick": asdict(light.pick) if light.pick is not None else None,
        "targets": [asdict(target) for target in light.targets],
    }


def _record(record: Record) -> dict[str, Any]:
    document: dict[str, Any] = {
        "technique": record.technique,
        "title": record.title,
        "settings": record.settings,
        "status": record.status,
        "reason": record.reason,
        "sweep": record.sweep,
        "given": record.given,
    }
    if record.status != "ok":
        return document
    assert record.area is not None and record.irradiance is not None
    return document | {
        "seeds": record.seeds,
        "error": {"area": record.area, "irradiance": record.irradiance, "flip": record.flip},
        "headline": record.headline,
        "headline_error": record.headline_error,
        "time_ms": {name: asdict(spread) for name, spread in record.time_ms.items()},
        "everything_ms": {name: asdict(spread) for name, spread in record.everything_ms.items()},
        "memory_bytes": record.memory_bytes,
        "dominant_error": record.area["dominant"],
        "sentence": record.area["sentence"],
        "plan": [asdict(step) for step in record.plan],
        "warnings": record.warnings,
        "statistics": [asdict(statistic) for statistic in record.statistics],
        "images": record.images,
        "on_pareto_front": record.on_pareto_front,
        "on_own_front": record.on_own_front,
    }


def _plain(value: Any) -> Any:
    """numpy scalars to Python's, and no NaN or infinity: JSON has no word for them."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def from_json(document: dict[str, Any]) -> Comparison:
    """The records that to_json() wrote, now or before targets were known; pixels are not in it.

    What is said of several lights together is not read back: it follows from the records (together.py).
    """
    return Comparison(
        environment=dict(document["environment"]),
        options=dict(document["options"]),
        scenes=[_scene_from(scene) for scene in document["scenes"]],
        failures=[Failure(**failure) for failure in document["failures"]],
    )


def _scene_from(raw: dict[str, Any]) -> SceneResult:
    lights = [_light_from(light) for light in raw["lights"]]
    width, height = raw["size"]
    named = {key: value for key, value in raw.items() if key != "together"}
    return SceneResult(**(named | {"size": (int(width), int(height)), "lights": lights}))


def _light_from(raw: dict[str, Any]) -> LightResult:
    ours = ("reference", "records", "budgets", "pick", "targets")
    named = {key: value for key, value in raw.items() if key not in ours}
    return LightResult(
        **named,
        pick=_pick_from(raw.get("pick")),
        targets=[_target_from(target) for target in raw.get("targets", [])],
        reference_info=raw["reference"],
        records=[_record_from(record) for record in raw["records"]],
        budgets=[Budget(**budget) for budget in raw["budgets"]],
    )


def _target_from(raw: dict[str, Any]) -> Target:
    return Target(**(raw | {"reaches": [Reach(**reach) for reach in raw["reaches"]]}))


def _pick_from(raw: dict[str, Any] | None) -> Pick | None:
    return Pick(**(raw | {"savings": [Saving(**saving) for saving in raw["savings"]]})) if raw is not None else None


def _record_from(raw: dict[str, Any]) -> Record:
    names = ("technique", "title", "settings", "status", "reason", "sweep")
    record = Record(**{name: raw[name] for name in names}, given=dict(raw.get("given", {})))
    if record.status != "ok":
        return record
    record.seeds, record.flip = raw["seeds"], raw["error"]["flip"]
    record.area, record.irradiance = _numbers(raw["error"]["area"]), _numbers(raw["error"]["irradiance"])
    record.time_ms = {
        name: Spread(**_numbers(spread) | {"tight": spread.get("tight")}) for name, spread in raw["time_ms"].items()
    }
    record.memory_bytes, record.on_pareto_front = raw["memory_bytes"], raw["on_pareto_front"]
    record.on_own_front, record.headline_error = raw.get("on_own_front", False), raw.get("headline_error", 0.0)
    record.everything_ms = {n: Spread(**_numbers(spread)) for n, spread in raw.get("everything_ms", {}).items()}
    record.plan = [Step(**step) for step in raw["plan"]]
    record.warnings = list(raw.get("warnings", []))  # reports from before had none
    record.statistics = [Statistic(**_numbers(statistic)) for statistic in raw["statistics"]]
    record.images = dict(raw["images"])
    return record


def _numbers(raw: dict[str, Any]) -> dict[str, Any]:
    """What _plain() wrote as nothing was not a number."""
    return {
        key: _numbers(value) if isinstance(value, dict) else math.nan if value is None else value
        for key, value in raw.items()
    }
