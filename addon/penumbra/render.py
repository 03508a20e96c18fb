"""One picture with one technique: the shaded image, and every layer a compositor wants beside it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import images
from .files import write_bytes
from .progress import Progress
from .records import Image, Settings, Statistic

if TYPE_CHECKING:
    from .bridge import SceneExport

_NOTHING_M = 1e10  # depth where the camera sees nothing, as Blender's own renders have it


@dataclass(slots=True)
class Frame:
    """A rendered picture in physical units; row 0 is the bottom row."""

    shaded: Image  # (h, w, 3) radiance, W/m^2/sr, with a little ambient light
    white: float  # radiance shown as white
    layers: dict[str, Image] = field(default_factory=dict)  # further EXR channels by full name
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)  # where the technique leaves its field of use
    statistics: dict[str, list[Statistic]] = field(default_factory=dict)  # by light, where the technique has any

    def write(self, path: Path) -> None:
        """.png: the sRGB view, exposed so that a well lit white surface is white; .exr: everything, unclipped."""
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix.lower() == ".png":
            write_bytes(path, images.png(images.srgb_bytes(self.shaded / self.white)))
            return
        channels = {letter: self.shaded[..., i] for i, letter in enumerate("RGB")}
        images.write_exr(path, channels | self.layers)


def work(export: SceneExport) -> float:
    """Units of progress: the view, and each light."""
    return 1.0 + 2.0 * len(export.lights)


def render(
    renderer: Any,
    export: SceneExport,
    technique: str,
    settings: Settings,
    lights: list[int],
    progress: Progress,
    *,
    keep_everything: bool = False,
) -> Frame:
    """Sum over the lights of irradiance x V x albedo / pi, plus ambient. A light the technique does not serve is
    fully lit, and a note says so.
    """
    progress.stage("view", 1.0)
    renderer.set_scene(export.scene)
    view = renderer.view()
    hit = np.asarray(view.instance) >= 0
    albedo = np.asarray(view.albedo)
    irradiance = np.zeros((*hit.shape, 3), np.float32)
    unshadowed = np.zeros_like(irradiance)
    frame = Frame(irradiance, 1.0)
    for index in lights:
        name = export.lights[index]
        progress.stage(f"{name}: {technique}", 2.0)
        arriving = np.asarray(renderer.irradiance(index))
        reason = str(renderer.supports(index, technique))
        if reason:
            frame.notes.append(f'"{name}" casts no shadow here: {reason}')
            visibility = np.ones(hit.shape, np.float32)
        else:
            answer = renderer.visibility(index, technique, settings, keep_everything=keep_everything, progress=progress)
            visibility = np.asarray(answer["visibility"])
            frame.warnings += [
                f'"{name}" is outside the field of use of {technique}: {warning["reason"]}'
                for warning in answer["warnings"]
            ]
            if answer["statistics"]:
                frame.statistics[name] = [Statistic(**statistic) for statistic in answer["statistics"]]
        unshadowed += arriving
        irradiance += arriving * visibility[..., None]
        layer = _layer_name(name)
        frame.layers[f"visibility.{layer}"] = visibility
        frame.layers[f"mask.{layer}"] = np.asarray(renderer.mask(index)).astype(np.float32)
    white = images.white_level(unshadowed)
    frame.white = white / np.pi
    frame.shaded = ((irradiance + images.ambient_of(white)) * albedo / np.pi).astype(np.float32)
    position = np.asarray(view.position_cr)
    backwards = np.asarray(export.scene.camera.world_from_camera, np.float64)[:3, 2]
    backwards = backwards / np.linalg.norm(backwards)
    depth = -(position @ backwards.astype(np.float32))
    frame.layers |= images.layer(
        "position", np.where(hit[..., None], position + np.asarray(view.eye_ws, np.float32), 0)
    )
    frame.layers |= images.layer("normal", np.where(hit[..., None], view.shading_normal_ws, 0))
    frame.layers |= {"depth.Z": np.where(hit, depth, np.float32(_NOTHING_M))}
    return frame


def _layer_name(light: str) -> str:
    """EXR separates layers and channels with a full stop, which therefore cannot be part of a name."""
    return re.sub(r"[^\w-]+", "_", light)
