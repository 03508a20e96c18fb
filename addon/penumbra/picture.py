"""A picture as Blender's render result wants it: radiance of all lights, and the passes, as a mean over pixel samples.

Knows the core, not Blender.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .passes import COMBINED, Pass
from .progress import Progress
from .records import Image, Settings

if TYPE_CHECKING:
    from .bridge import SceneExport

DEPTH = "Depth"
NORMAL = "Normal"
POSITION = "Position"
NOTHING_M = 1e10  # depth where the camera sees nothing, as Blender's own renders have it


@dataclass(frozen=True)
class Wanted:
    """What one picture is to hold."""

    technique: str
    settings: dict[str, Settings]  # of every technique that is used
    passes: Sequence[Pass] = ()
    extra: frozenset[str] = frozenset()  # of DEPTH, NORMAL, POSITION
    pixel_samples: int = 1
    transparent: bool = False
    keep_everything: bool = False
    reference_error: float = 0.004

    def techniques(self) -> list[str]:
        """All that must be rendered, each once, the picture's own first."""
        return list(dict.fromkeys([self.technique, *(p.technique for p in self.passes if p.technique)]))


@dataclass
class Picture:
    """Row 0 is the bottom row."""

    planes: dict[str, Image] = field(default_factory=dict)  # by pass name; (h, w, channels)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)  # where a technique leaves its field of use
    samples: int = 0  # pixel samples that are in it; fewer than wanted if it was stopped


class StoppedError(Exception):
    """The user wants no more."""


def pixel_offsets(count: int) -> list[tuple[float, float]]:
    """`count` places within a pixel, (0, 0) its centre: the R2 sequence, evenly spread for every count."""
    if count == 1:
        return [(0.0, 0.0)]
    steps = (0.7548776662466927, 0.5698402909980532)  # 1 / g and 1 / g^2 for g^3 = g + 1
    return [tuple(((0.5 + i * step) % 1.0) - 0.5 for step in steps) for i in range(count)]  # type: ignore[misc]


class Painter:
    """Makes one picture, one pixel sample after another, so that what is there can be shown before all are."""

    def __init__(self, renderer: Any, export: SceneExport, wanted: Wanted, progress: Progress) -> None:
        self._renderer = renderer
        self._export = export
        self._wanted = wanted
        self._progress = progress
        self._sums: dict[str, Any] = {}
        self._centre: dict[str, Image] = {}
        self._picture = Picture()

    def work(self) -> float:
        """Units of progress of the whole picture."""
        each = len(self._wanted.techniques()) + (2.0 if self._needs_reference() else 0.0)
        return self._wanted.pixel_samples * (1.0 + len(self._export.lights) * each)

    def sample(self, number: int) -> Picture:
        """Adds a pixel sample. @returns the mean of those so far"""
        scene = self._export.scene
        camera = scene.camera
        camera.pixel_offset = pixel_offsets(self._wanted.pixel_samples)[number]
        scene.camera = camera
        self._progress.stage("what the camera sees", 1.0)
        self._renderer.set_scene(scene)
        view = self._renderer.view()
        hit = np.asarray(view.instance) >= 0
        if number == 0:
            self._fixed(view, hit)
        for name, plane in self._planes(view, hit, number).items():
            if name in self._sums:
                self._sums[name] += plane
            else:
                self._sums[name] = plane.astype(np.float32)
        self._picture.samples = number + 1
        scale = np.float32(1.0 / self._picture.samples)
        self._picture.planes = self._centre | {name: total * scale for name, total in self._sums.items()}
        return self._picture

    def _needs_reference(self) -> bool:
        return any(p.what in ("reference", "error") for p in self._wanted.passes)

    def _planes(self, view: Any, hit: Any, number: int) -> dict[str, Image]:
        """All planes of one pixel sample."""
        export, wanted = self._export, self._wanted
        albedo = np.asarray(view.albedo)
        irradiance = np.zeros((*hit.shape, 3), np.float32)
        irradiance += np.pi * np.asarray(export.world, np.float32)  # of a sky that nothing hides
        one = np.ones(hit.shape, np.float32)
        by_technique: dict[str, dict[str, Image]] = {name: {} for name in wanted.techniques()}
        truths: dict[str, Image] = {}
        for index, light in enumerate(export.lights):
            arriving = np.asarray(self._renderer.irradiance(index))
            for technique, seen in by_technique.items():
                self._progress.stage(f"{light}: {technique}", 1.0)
                seen[light] = self._visibility(index, light, technique, number, one)
            irradiance += arriving * by_technique[wanted.technique][light][..., None]
            if self._needs_reference():
                self._progress.stage(f"{light}: reference", 2.0)
                truths[light] = self._truth(index, number)
        combined = np.zeros((*hit.shape, 4), np.float32)
        combined[..., :3] = irradiance * albedo / np.float32(np.pi)
        combined[..., 3] = 1.0
        combined[~hit] = (0.0, 0.0, 0.0, 0.0) if wanted.transparent else (*export.world, 1.0)
        planes = {COMBINED: combined}
        for entry in wanted.passes:
            planes[entry.name] = _pass_plane(entry, by_technique, truths, one)[..., None]
        return planes

    def _visibility(self, index: int, light: str, technique: str, number: int, one: Image) -> Image:
        settings = dict(self._wanted.settings.get(technique, {}))
        if "seed" in settings:  # each pixel sample its own noise, and so less in their mean
            settings["seed"] = (int(settings["seed"]) + number) % (1 << 31)
        reason = str(self._renderer.supports(index, technique))
        if reason:
            if number == 0:
                self._picture.notes.append(f'"{light}" casts no shadow with {technique}: {reason}')
            return one
        answer = self._renderer.visibility(
            index,
            technique,
            settings,
            keep_everything=self._wanted.keep_everything,
            statistics=False,
            progress=self._progress,
            reuse=True,
        )
        if number == 0:
            self._picture.warnings += [
                f'"{light}" is outside the field of use of {technique}: {warning["reason"]}'
                for warning in answer["warnings"]
            ]
        return np.asarray(answer["visibility"])

    def _truth(self, index: int, number: int) -> Image:
        # The mean of n pictures with errors of sqrt(n) times the one asked for has the one asked for.
        error = min(self._wanted.reference_error * self._wanted.pixel_samples**0.5, 0.25)
        answer = self._renderer.reference(index, standard_error=error, seed=number + 1, progress=self._progress)
        return np.asarray(answer["area"])

    def _fixed(self, view: Any, hit: Any) -> None:
        """Planes whose mean over a pixel would mean nothing: of the first sample alone."""
        if NORMAL in self._wanted.extra:
            self._centre[NORMAL] = np.where(hit[..., None], view.shading_normal_ws, 0).astype(np.float32)
        if DEPTH not in self._wanted.extra and POSITION not in self._wanted.extra:
            return
        position = np.asarray(view.position_cr)
        if POSITION in self._wanted.extra:
            eye = np.asarray(view.eye_ws, np.float32)
            self._centre[POSITION] = np.where(hit[..., None], position + eye, 0).astype(np.float32)
        if DEPTH in self._wanted.extra:
            backwards = np.asarray(self._export.scene.camera.world_from_camera, np.float64)[:3, 2]
            backwards = backwards / np.linalg.norm(backwards)
            depth = -(position @ backwards.astype(np.float32))
            self._centre[DEPTH] = np.where(hit, depth, np.float32(NOTHING_M)).astype(np.float32)[..., None]


def _pass_plane(entry: Pass, by_technique: dict[str, dict[str, Image]], truths: dict[str, Image], one: Image) -> Image:
    """One of Penumbra's own passes: of its light, or the product over all lights."""

    def of(images: dict[str, Image]) -> Image:
        if entry.light:
            return images.get(entry.light, one)
        product = one
        for image in images.values():
            product = product * image
        return product

    if entry.what == "reference":
        return of(truths)
    seen = of(by_technique[entry.technique])
    return seen if entry.what == "visibility" else seen - of(truths)
