"""One comparison: every technique against the truth, on the same view, with errors, times, memory and plan."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import cache as caching
from . import environment, images, native, precision, sweep, verdict
from .errors import UserError, sentence_of, unknown
from .progress import Progress
from .records import (
    Failure,
    Image,
    LightResult,
    Record,
    ReferenceResult,
    SceneResult,
    Settings,
    Spread,
    Statistic,
    Step,
    Value,
)

if TYPE_CHECKING:
    from .bridge import SceneExport

SEEDS = 4  # of a randomised technique, to tell its noise from its bias
SWEEP_SEEDS = 2  # the fewest that give a variance
TIMING_MEMORY = 2 << 30  # bytes

# Estimated seconds, only for the progress bar.
_REFERENCE_WORK, _IMAGE_WORK, _TIMING_WORK = 12.0, 0.5, 5.0


@dataclass(frozen=True)
class Options:
    """What was asked for; the command line's defaults."""

    techniques: tuple[str, ...] = ()  # empty: all
    settings: dict[str, Settings] = field(default_factory=dict)  # by technique
    lights: tuple[str, ...] = ()  # names; empty: all
    sweep: str = "off"  # off, quick, full
    reference_error: float = 0.002
    target_rmse: float | None = None
    keep_everything: bool = False
    use_cache: bool = True
    timing_seconds: float = 3.0  # for each median, soft
    measure_savings: bool = False  # time each job with every rule kept as well


@dataclass(frozen=True)
class Job:
    """One technique with one set of settings."""

    info: dict[str, Any]
    settings: Settings
    sweep: dict[str, Any] | None = None

    @property
    def id(self) -> str:
        return str(self.info["id"])

    def seeds(self) -> list[Settings]:
        """The settings of each image to make: several seeds if the technique is randomised."""
        ids = {setting["id"]: setting for setting in self.info["settings"]}
        if not self.info["randomised"] or "seed" not in ids:
            return [self.settings]
        first = int(self.settings.get("seed", ids["seed"]["default"]))
        count = SWEEP_SEEDS if self.sweep else SEEDS
        low, high = int(ids["seed"]["minimum"]), int(ids["seed"]["maximum"])
        return [self.settings | {"seed": low + (first - low + i) % (high - low + 1)} for i in range(count)]


def choose_techniques(infos: list[dict[str, Any]], ids: tuple[str, ...]) -> list[dict[str, Any]]:
    """The techniques asked for, in the order users see them. @raises UserError for an unknown id."""
    known = [str(info["id"]) for info in infos]
    for given in ids:
        if given not in known:
            raise unknown("technique", given, known)
    return [info for info in infos if not ids or info["id"] in ids]


def parse_setting(infos: list[dict[str, Any]], text: str) -> tuple[str, str, Value]:
    """ "pcf.kernel=5" as ("pcf", "kernel", 5). @raises UserError with the choices."""
    left, equals, right = text.partition("=")
    technique, dot, key = left.strip().partition(".")
    if not equals or not dot:
        raise UserError(f'--set wants technique.key=value, not "{text}"')
    by_id = {str(info["id"]): info for info in infos}
    if technique not in by_id:
        raise unknown("technique", technique, by_id)
    settings = {str(setting["id"]): setting for setting in by_id[technique]["settings"]}
    if key not in settings:
        raise unknown(f"setting of {technique}", key, settings)
    return technique, key, _parse_value(f"{technique}.{key}", settings[key], right.strip())


def _parse_value(name: str, setting: dict[str, Any], text: str) -> Value:
    kind = setting["type"]
    if kind == "choice":
        if setting["choices"] and text not in setting["choices"]:  # no choices: any name
            raise unknown(f"value of {name}", text, setting["choices"])
        return text
    if kind == "bool":
        words = {
            "true": True,
            "yes": True,
            "on": True,
            "1": True,
            "false": False,
            "no": False,
            "off": False,
            "0": False,
        }
        if text.lower() not in words:
            raise UserError(f'{name} is on or off, not "{text}"')
        return words[text.lower()]
    try:
        value: int | float = int(text) if kind == "int" else float(text)
    except ValueError:
        value = math.nan
    low, high = setting["minimum"], setting["maximum"]
    if not low <= value <= high:
        noun = "a whole number" if kind == "int" else "a number"
        unit = f" {setting['unit']}" if setting["unit"] else ""
        raise UserError(f'{name} is {noun} from {low:g} to {high:g}{unit}, not "{text}"')
    return value


def jobs_of(info: dict[str, Any], settings: Settings, mode: str) -> Iterator[Job]:
    """What was asked for, then the steps of the sweep."""
    yield Job(info, settings)
    for change in sweep.steps(info, settings, mode):
        yield Job(info, settings | change, sweep.entry(change))


def timing_memory() -> int:
    """Bytes that what is timed together may keep: a full sweep keeps gigabytes."""
    return min(TIMING_MEMORY, (environment.memory_bytes() or TIMING_MEMORY * 4) // 4)


def groups(sizes: list[int], most: int) -> list[list[int]]:
    """Indices in groups of at most `most` in all, each in the first that has room; what is larger is alone."""
    made: list[list[int]] = []
    room: list[int] = []
    for index, size in enumerate(sizes):
        place = next((k for k, left in enumerate(room) if size <= left), len(made))
        if place == len(made):
            made.append([])
            room.append(most)
        made[place].append(index)
        room[place] -= size
    return made


def choose_lights(names: list[str], wanted: tuple[str, ...]) -> list[int]:
    """Indices of the lights asked for. @raises UserError for an unknown name."""
    for name in wanted:
        if name not in names:
            raise unknown("light", name, names)
    return [i for i, name in enumerate(names) if not wanted or name in wanted]


class Comparer:
    """Compares on one renderer. Failures of a technique are recorded and do not stop the others."""

    def __init__(self, core: Any, renderer: Any, options: Options, progress: Progress) -> None:
        self._core = core
        self._renderer = renderer
        self._options = options
        self._progress = progress
        self._cache = caching.ReferenceCache.of_user() if options.use_cache else None
        self.failures: list[Failure] = []

    def work(self, lights: int) -> float:
        """Estimated seconds for a scene with so many lights, for the progress bar."""
        count = sum(len(jobs) for jobs in self._jobs().values())
        return lights * (_REFERENCE_WORK + count * (_IMAGE_WORK + _TIMING_WORK))

    def _jobs(self) -> dict[str, list[Job]]:
        infos = choose_techniques(self._core.techniques(), self._options.techniques)
        return {
            str(info["id"]): list(jobs_of(info, self._options.settings.get(info["id"], {}), self._options.sweep))
            for info in infos
        }

    def compare(self, export: SceneExport, path: str) -> SceneResult:
        """All chosen lights of one scene.

        @raises core.InvalidScene if the scene does not pass the border, UserError for an unknown light
        """
        scene = export.scene
        chosen = choose_lights(list(export.lights), self._options.lights)
        self._renderer.set_scene(scene)
        view = self._renderer.view()
        hit = (np.asarray(view.instance) >= 0).astype(np.uint8)
        result = SceneResult(
            path=path,
            camera=export.camera,
            frame=export.frame,
            size=(int(view.width), int(view.height)),
            triangles=export.triangles,
            summary={
                "triangles": int(scene.triangle_count),
                "instances": int(scene.instance_count),
                "lights": len(scene.lights),
                "visible_pixels": int(hit.sum()),
            },
            notes=list(export.notes),
            albedo=np.array(view.albedo, np.float32),
            hit=hit,
        )
        digest = self._digest(scene)
        for index in chosen:
            where = f"{result.name}, {scene.lights[index].name}"
            result.lights.append(self._light(scene, index, digest, where))
        return result

    def _digest(self, scene: Any) -> str:
        """Of all of the scene that a reference depends on; empty without a cache."""
        return str(scene.digest()) if self._cache is not None else ""

    def _light(self, scene: Any, index: int, digest: str, where: str) -> LightResult:
        light = scene.lights[index]
        shape, size_m, angle = describe_light(light)
        result = LightResult(name=light.name, shape=shape, size_m=size_m, angle_rad=angle)
        jobs = [job for jobs in self._jobs().values() for job in jobs]
        try:
            result.summary = dict(self._renderer.summary(index))
            result.irradiance = np.array(self._renderer.irradiance(index), np.float32)
            result.reference = self._reference(index, digest, where)
        except self._core.Cancelled:
            raise
        except self._core.Error as error:
            reason = f"no reference: {sentence_of(error)}"
            self.failures.append(Failure(where, reason))
            result.records = [_record(job, "failed", reason) for job in jobs]
            return result
        result.reference_info = reference_info(result.reference)
        done: list[tuple[int, Record, Job]] = []
        for job in jobs:
            record = self._image(index, job, result.reference, where)
            result.records.append(record)
            if record.status == "ok":
                done.append((index, record, job))
        self._times(done, where)
        verdict.judge(result, self._options.target_rmse, self._core.pareto_front)
        return result

    def _reference(self, index: int, digest: str, where: str) -> ReferenceResult:
        self._progress.stage(f"{where}: reference", _REFERENCE_WORK)
        options = self._options
        entry = ""
        if self._cache is not None:
            entry = caching.key(
                core=native.fingerprint(),
                view_by=self._renderer.environment["view_by"],
                scene=digest,
                light=index,
                standard_error=options.reference_error,
                seed=1,
                keep_everything=options.keep_everything,
            )
            kept = self._cache.load(entry)
            if kept is not None:
                return kept
        raw = self._renderer.reference(
            index,
            standard_error=options.reference_error,
            seed=1,
            keep_everything=options.keep_everything,
            progress=self._progress,
        )
        reference = ReferenceResult(
            method=str(raw["method"]),
            area=raw["area"],
            irradiance=raw["irradiance"],
            standard_error=raw["standard_error"],
            irradiance_standard_error=raw["irradiance_standard_error"],
            mask=raw["mask"],
            rays=int(raw["rays"]),
            mean_rays_per_pixel=float(raw["mean_rays_per_pixel"]),
            standard_error_asked=options.reference_error,
            time_ms=float(raw["time_ms"]),
            reached=bool(raw["reached"]),
            pixels_skipped=int(raw["pixels_skipped"]),
        )
        if self._cache is not None:
            self._cache.store(entry, reference)
        return reference

    def _image(self, index: int, job: Job, reference: ReferenceResult, where: str) -> Record:
        self._progress.stage(f"{where}: {job.info['title']}", _IMAGE_WORK)
        try:
            reason = str(self._renderer.supports(index, job.id))
            if reason:
                return _record(job, "unsupported", reason)
            seeds = job.seeds()
            answers = []
            for i, settings in enumerate(seeds):
                answers.append(
                    self._renderer.visibility(
                        index,
                        job.id,
                        settings,
                        keep_everything=self._options.keep_everything,
                        progress=lambda share, text, i=i: self._progress((i + share) / (len(seeds) + 1)),
                    )
                )
        except self._core.Cancelled:
            raise
        except self._core.Error as error:
            return self._fail(job, where, sentence_of(error))
        pictures = [np.asarray(answer["visibility"], np.float32) for answer in answers]
        first = answers[0]
        record = _record(job, "ok", "")
        record.settings = dict(first["settings"])
        record.seeds = len(seeds)
        record.memory_bytes = int(first["memory_bytes"])
        record.plan = [_step(step) for step in first["plan"]]
        record.warnings = [str(warning["reason"]) for warning in first["warnings"]]
        record.statistics = [Statistic(**statistic) for statistic in first["statistics"]]
        measure, mask = self._core.measure_errors, reference.mask
        record.area = dict(measure(pictures, reference.area, reference.standard_error, mask))
        record.irradiance = dict(measure(pictures, reference.irradiance, reference.irradiance_standard_error, mask))
        record.headline_error = precision.headline_error(pictures, reference.area, reference.standard_error, mask)
        record.flip = images.flip_mean(pictures[0], reference.area, mask) if images.has_flip() else None
        if not record.is_sweep_step:
            record.visibility = pictures[0]
        return record

    def _fail(self, job: Job, where: str, reason: str) -> Record:
        self.failures.append(Failure(f"{where}, {job.id}", reason))
        return _record(job, "failed", reason)

    def _times(self, done: list[tuple[int, Record, Job]], where: str) -> None:
        """Times of all records of a light, interleaved so that drift of the machine hits all alike.

        What is interleaved lives at once: where all do not fit, they are timed in as few groups as do.
        """
        for group in groups([record.memory_bytes for _, record, _ in done], timing_memory()):
            self._time_group([done[i] for i in group], where)

    def _time_group(self, group: list[tuple[int, Record, Job]], where: str) -> None:
        self._progress.stage(f"{where}: timing", _TIMING_WORK * len(group))
        try:
            self._measure(group)
        except self._core.Cancelled:
            raise
        except self._core.Error:
            # One of them spoils the measurement of all: time each by itself to find it and to keep the others.
            for entry in group:
                _, record, job = entry
                try:
                    self._measure([entry])
                except self._core.Cancelled:
                    raise
                except self._core.Error as error:
                    record.status, record.reason = "failed", f"timing: {sentence_of(error)}"
                    self.failures.append(Failure(f"{where}, {job.id}", record.reason))

    def _measure(self, done: list[tuple[int, Record, Job]]) -> None:
        # A dynamic, a static and a kept frame of each, and the view, each within timing_seconds; most end sooner.
        jobs = [(job.id, job.settings) for _, _, job in done]
        kept: list[list[str]] = [[] for _ in jobs]
        if self._options.measure_savings and not self._options.keep_everything:
            jobs, kept = jobs * 2, kept + [["all"] for _ in jobs]
        started, longest = time.monotonic(), self._options.timing_seconds * (3 * len(jobs) + 1)
        measured = self._renderer.measure(
            done[0][0],
            jobs,
            keep_everything=self._options.keep_everything,
            max_seconds=self._options.timing_seconds,
            progress=lambda fraction, text: self._progress((time.monotonic() - started) / longest),
            keep_rules=kept,
        )
        for (_, record, _), answer in zip(done, measured[len(done) :], strict=False):
            record.everything_ms = {name: _spread(answer[name]) for name in ("dynamic", "static")}
        for (_, record, _), answer in zip(done, measured, strict=False):
            record.time_ms = {name: _spread(answer[name]) for name in ("setup", "dynamic", "static", "kept", "view")}
            record.time_ms["setup"].tight = None  # it happens once
            record.plan = [_step(step) for step in answer["plan"]]
            record.memory_bytes = int(answer["memory_bytes"]) or record.memory_bytes


def _record(job: Job, status: Any, reason: str) -> Record:
    return Record(
        technique=job.id,
        title=str(job.info["title"]),
        settings=dict(job.settings),
        given=dict(job.settings),
        status=status,
        reason=reason,
        sweep=job.sweep,
    )


def _spread(raw: dict[str, Any]) -> Spread:
    return Spread(**{item.name: raw[item.name] for item in dataclasses.fields(Spread)})


def _step(raw: dict[str, Any]) -> Step:
    return Step(
        step=str(raw["step"]),
        state="run" if raw["state"] == "run" else "left_out",
        reason=str(raw.get("reason", "")),
        rule=str(raw.get("rule", "")),
        tolerance=float(raw.get("tolerance", 0.0)),
        time_ms=float(raw.get("time_ms", 0.0)),
    )


def reference_info(reference: ReferenceResult) -> dict[str, Any]:
    """The reference's entry in report.json, without its image paths."""
    inside = reference.mask != 0
    return {
        "method": reference.method,
        "samples": reference.mean_rays_per_pixel,
        "rays": reference.rays,
        "standard_error": _rms(reference.standard_error, inside),
        "standard_error_max": float(reference.standard_error[inside].max()) if inside.any() else 0.0,
        "irradiance_standard_error": _rms(reference.irradiance_standard_error, inside),
        "standard_error_asked": reference.standard_error_asked,
        "reached": reference.reached,
        "pixels": int(inside.sum()),
        "pixels_skipped": reference.pixels_skipped,
        "time_ms": reference.time_ms,
        "from_cache": reference.from_cache,
    }


def _rms(values: Image, inside: npt.NDArray[np.bool_]) -> float:
    chosen = values[inside].astype(np.float64)
    return float(np.sqrt(np.mean(chosen * chosen))) if chosen.size else 0.0


def describe_light(light: Any) -> tuple[str, list[float], float | None]:
    """(shape in words, size in metres, angle of a sun). Sizes are full widths: diameter, sides, length."""

    def length(vector: Any) -> float:
        return float(np.linalg.norm(np.asarray(vector, np.float64)))

    kind = str(light.kind)
    if kind == "sun":
        return "sun", [], float(light.sun_angle_rad)
    if kind in ("point", "spot"):
        return kind, [2.0 * float(light.radius_m)], None
    if kind == "polygon":
        corners = np.asarray(light.corners_ws, np.float64)
        return "polygon", [length(corners[i] - corners[i - 1]) for i in range(len(corners))], None
    sides = [2.0 * length(light.half_u_ws), 2.0 * length(light.half_v_ws)]
    return kind, sides[:1] if kind == "line" else sides, None


@contextlib.contextmanager
def core_errors(core: Any) -> Iterator[None]:
    """The core's refusals of bad input or of this machine, as sentences for the user."""
    try:
        yield
    except core.Cancelled:
        raise KeyboardInterrupt from None
    except core.Error as error:
        raise UserError(sentence_of(error)) from error
