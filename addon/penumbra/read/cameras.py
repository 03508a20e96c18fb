"""Blender's cameras and render settings in the core's words, pixel for pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import BridgeError


@dataclass(frozen=True)
class Frame:
    """The picture to be taken: pixels of the whole frame, the pixel's shape, and the part that is wanted."""

    width: int
    height: int
    pixel_aspect: float = 1.0  # height of a pixel over its width
    border: tuple[int, int, int, int] | None = None  # left, bottom, right, top in pixels

    @property
    def size(self) -> tuple[int, int]:
        left, bottom, right, top = self.border or (0, 0, self.width, self.height)
        return right - left, top - bottom


def read_frame(scene: Any, size: tuple[int, int] | None = None) -> Frame:
    """Resolution, percentage, pixel aspect and render border of a scene, rounded as Blender rounds them."""
    render = scene.render
    if size is not None:
        width, height = int(size[0]), int(size[1])
        if width < 1 or height < 1:
            raise BridgeError(f"the picture's size is {width} x {height} pixels; it must be at least 1 x 1")
    else:
        width = max(1, render.resolution_x * render.resolution_percentage // 100)
        height = max(1, render.resolution_y * render.resolution_percentage // 100)
    border = None
    if render.use_border:
        left, right = (int(np.float32(f) * width) for f in (render.border_min_x, render.border_max_x))
        bottom, top = (int(np.float32(f) * height) for f in (render.border_min_y, render.border_max_y))
        if right > left and top > bottom:
            border = (left, bottom, right, top)
    return Frame(width, height, render.pixel_aspect_y / render.pixel_aspect_x, border)


@dataclass
class Lens:
    """A camera in the core's words, for one frame."""

    orthographic: bool
    half_width: float  # at distance 1, or in metres where orthographic
    shift: tuple[float, float]  # of the picture's centre, in picture widths


def read_lens(camera: Any, frame: Frame) -> Lens:
    """Blender's lens and sensor for one frame: `BKE_camera_params_compute_viewplane` said in the core's words."""
    across, up = float(frame.width), float(frame.height) * frame.pixel_aspect  # both in pixel widths
    fit = camera.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if across >= up else "VERTICAL"
    fitted = across if fit == "HORIZONTAL" else up
    # The sensor's height counts only where the fit is set to vertical by hand.
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width

    orthographic = camera.type == "ORTHO"
    extent = camera.ortho_scale if orthographic else sensor / camera.lens
    per_pixel = extent / fitted
    centre_x, centre_y = camera.shift_x * fitted, camera.shift_y * fitted  # in pixel widths
    if frame.border is not None:
        left, bottom, right, top = frame.border
        centre_x += (left + right - frame.width) / 2.0
        centre_y += (bottom + top - frame.height) / 2.0 * frame.pixel_aspect
    width = frame.size[0]
    return Lens(orthographic, per_pixel * width / 2.0, (centre_x / width, centre_y / width))
