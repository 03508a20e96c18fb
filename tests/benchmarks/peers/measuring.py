"""Measures all points of a scene in turns and keeps each on disk, so that a killed run goes on where it was."""

from __future__ import annotations

import contextlib
import json
import os
import random
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from penumbra.environment import usable_cores
from penumbra.records import Settings

from . import exchange, plan
from .ours import TRUTH_FILE
from .plan import OURS, Limits, Point
from .worker import Answer, Worker, WorkerError

KEPT_ERRORS = ("rmse", "bias", "penumbra_rmse", "p99", "max", "pixels", "penumbra_pixels", "reference_standard_error")


@dataclass
class Measured:
    """What is known of a point."""

    point: Point
    runs: list[Answer] = field(default_factory=list)
    errors: dict[str, dict[str, float]] = field(default_factory=dict)  # by question
    failure: str = ""

    def times(self, key: str) -> list[float]:
        return [float(run[key]) for run in self.runs if key in run]

    def median(self, key: str) -> float:
        return float(np.median(self.times(key)))

    def enough(self, limits: Limits) -> bool:
        if self.failure:
            return True
        times = sorted(self.times("wall_ms"))
        if not times or not self.errors or len(times) >= limits.max_runs:
            return len(times) >= limits.max_runs
        if sum(self.times("spent_ms")) >= 1e3 * limits.point_s:
            return True
        return len(times) >= limits.min_runs and interval(times) < limits.tight * float(np.median(times))


def interval(times: list[float]) -> float:
    """Width of the median's 95 % interval by order statistics, as the core takes it."""
    n = len(times)
    rank = max(0, int(n / 2 - 0.98 * n**0.5 + 0.5) - 1)
    ordered = sorted(times)
    return ordered[n - 1 - rank] - ordered[rank]


class Store:
    """One file per point."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def load(self, point: Point) -> Measured:
        file = self._file(point)
        if not file.is_file():
            return Measured(point)
        kept = json.loads(file.read_text(encoding="utf-8"))
        return Measured(point, kept["runs"], kept["errors"], kept["failure"])

    def save(self, measured: Measured) -> None:
        point = measured.point
        document = {
            "worker": point.worker,
            "curve": point.curve,
            "label": point.label,
            "settings": point.settings,
            "runs": measured.runs,
            "errors": measured.errors,
            "failure": measured.failure,
        }
        write(self._file(point), document)

    def _file(self, point: Point) -> Path:
        return self._folder / f"{point.id}.json"


def write(file: Path, document: Any) -> None:
    """JSON, whole or not at all."""
    partial = file.with_suffix(".partial")
    partial.write_text(json.dumps(document, indent=1), encoding="utf-8")
    os.replace(partial, file)


@dataclass(frozen=True)
class Programs:
    """How the workers are started."""

    script: Path
    embree: Path | None

    def command(self, worker: str, folder: Path) -> list[str]:
        if worker == "embree":
            if self.embree is None:
                raise WorkerError("penumbra_embree_loop was not found; build it or name it with --embree")
            return [str(self.embree), str(folder / exchange.SOUP_FILE)]
        return [sys.executable, str(self.script), "--worker", worker, str(folder)]


@contextlib.contextmanager
def open_workers(programs: Programs, names: list[str], folder: Path) -> Iterator[dict[str, Worker | WorkerError]]:
    """Those that come up, and why the others do not."""
    workers: dict[str, Worker | WorkerError] = {}
    try:
        for name in names:
            try:
                workers[name] = Worker(programs.command(name, folder), folder / f"{name}.log")
            except (WorkerError, OSError) as error:
                workers[name] = error if isinstance(error, WorkerError) else WorkerError(str(error))
                print(f"  {name}: left out: {error}", flush=True)
        yield workers
    finally:
        for worker in workers.values():
            if isinstance(worker, Worker):
                worker.close()


class Round:
    """Measures one scene."""

    def __init__(self, folder: Path, programs: Programs, sweep: str, standard_error: float) -> None:
        self._folder = folder
        self._programs = programs
        self._sweep = sweep
        self._limits = plan.LIMITS[sweep]
        self._standard_error = standard_error
        self._store = Store(folder / "points")

    def run(self) -> dict[str, Any]:
        """All points; what each worker said of itself."""
        facts_file = self._folder / "facts.json"
        with open_workers(self._programs, [OURS], self._folder) as ours:
            worker = ours[OURS]
            if isinstance(worker, WorkerError):
                raise worker
            if not (self._folder / TRUTH_FILE).is_file():
                took = worker.ask("truth", standard_error=self._standard_error)
                print(f"  truth: {took['wall_ms'] / 1e3:.1f} s, {took['pixels']} pixels compared", flush=True)
            jobs = worker.ask("jobs", sweep=self._sweep)["jobs"]
            names = list(dict.fromkeys(curve.worker for curve in plan.CURVES))
            points = [our_point(job) for job in jobs]
            for curve in plan.CURVES:
                points += curve.points(self._sweep)
            measured = [self._store.load(point) for point in points]
            open_points = [each for each in measured if not each.enough(self._limits)]
            needed = [name for name in names if any(each.point.worker == name for each in open_points)]
            with open_workers(self._programs, needed, self._folder) as peers:
                facts = json.loads(facts_file.read_text(encoding="utf-8")) if facts_file.is_file() else {}
                for name, each in ({OURS: worker} | peers).items():
                    if isinstance(each, Worker):
                        facts[name] = each.facts
                write(facts_file, facts)
                self._measure(open_points, {OURS: worker} | peers)
        return facts

    def _measure(self, points: list[Measured], workers: dict[str, Any]) -> None:
        truth = dict(np.load(self._folder / TRUTH_FILE))
        order = random.Random(1)
        turn = 0
        while points:
            turn += 1
            print(f"  round {turn}: {len(points)} points", flush=True)
            # The first round goes from cheap to dear, so that dear settings can be left out.
            for each in points if turn == 1 else order.sample(points, len(points)):
                worker = workers[each.point.worker]
                if isinstance(worker, WorkerError):
                    each.failure = str(worker)
                    continue  # not kept: it may come up the next time
                self._one(each, worker, points, truth)
                self._store.save(each)
            points = [each for each in points if not each.enough(self._limits)]

    def _one(self, each: Measured, worker: Worker, all_points: list[Measured], truth: dict[str, Any]) -> None:
        point = each.point
        is_ours = point.worker == OURS
        if is_ours and self._too_dear(point, all_points):
            each.failure = "left out: cheaper settings of it take long already"
            return
        # Its own time has all of the picture's cost in it, so the first run serves for the error too.
        out = self._folder / f"picture_{point.worker}.{'bin' if point.worker == 'embree' else 'npy'}"
        arguments: dict[str, Any] = {"settings": point.settings, "out": "" if each.errors else str(out)}
        if is_ours:
            arguments["seconds"] = self._limits.ours_s
        try:
            started = time.perf_counter()
            answer = worker.ask("render", **arguments)
            each.runs.append(answer | {"spent_ms": 1e3 * (time.perf_counter() - started)})
        except WorkerError as error:
            each.failure = str(error)
            print(f"  {point.curve}, {point.label}: {error}", flush=True)
            return
        if not each.errors:
            each.errors = errors_of(point.worker, out, truth)
            out.unlink()

    def _too_dear(self, point: Point, all_points: list[Measured]) -> bool:
        """Whether a setting with the same knobs turned no further takes too long already, by processor time."""
        limit_ms = 1e3 * self._limits.dearest_s * usable_cores()
        return any(
            other.median("cpu_ms") > limit_ms
            for other in all_points
            if other.runs and other.point.curve == point.curve and other.point is not point
            if no_dearer(other.point.settings["settings"], point.settings["settings"])
        )


def no_dearer(one: Settings, other: Settings) -> bool:
    """Whether both change the same numbers, and the first none of them further."""
    numbers = (int, float)
    return one.keys() == other.keys() and all(
        isinstance(value, numbers) and isinstance(other[key], numbers) and value <= other[key]
        for key, value in one.items()
    )


def our_point(job: dict[str, Any]) -> Point:
    label = ", ".join(f"{key} {value}" for key, value in job["settings"].items()) or "defaults"
    return Point(OURS, job["technique"], label, job)


# Which truths each worker's pictures are held against. "irradiance" and "area" are asked at the pixel's centre,
# "filtered" is the irradiance over the whole pixel, which renderers with a box filter answer.
QUESTIONS = {
    OURS: ("area", "irradiance"),
    "embree": ("irradiance", "area"),
    "cycles": ("filtered",),
    "mitsuba": ("filtered",),
    "eevee": ("irradiance",),
}


def errors_of(worker: str, picture: Path, truth: dict[str, Any]) -> dict[str, dict[str, float]]:
    """By question; of several images in the picture (Embree's), each against its own."""
    import penumbra_core as core

    mask = truth["mask"]
    questions = QUESTIONS[worker]
    several = picture.suffix == ".bin"
    images = np.fromfile(picture, "<f4").reshape(-1, *mask.shape) if several else [np.load(picture)] * len(questions)
    found = {}
    for question, image in zip(questions, images, strict=True):
        errors = core.measure_errors([image], truth[question], truth[f"{question}_error"], mask)
        found[question] = {key: float(errors[key]) for key in KEPT_ERRORS}
    return found
