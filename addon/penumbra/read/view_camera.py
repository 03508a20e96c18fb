"""The camera of a 3D viewport in the core's words, from the two matrices that Blender draws it with."""

from __future__ import annotations

from typing import Any

import numpy as np

from .transforms import DoubleArray, matrix_of

_MARGIN = 1.01


def view_camera(
    core: Any,
    view_matrix: Any,
    window_matrix: Any,
    size_px: tuple[int, int],
    box_points: DoubleArray,
    part: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
) -> Any:
    """A core.Camera that sees, pixel for pixel, what the region shows; zoom, shift and border are in the matrices.

    view_matrix, window_matrix: of the region's RegionView3D, (4, 4), Blender's conventions
    size_px: width and height of the picture, smaller than the region while something moves
    box_points: (n, 3) corners of what is to be seen: an orthographic eye must stand before all of it
    part: left, bottom, right, top of the region that is wanted, 0 .. 1
    """
    view, window = matrix_of(view_matrix), matrix_of(window_matrix)
    world_from_camera = np.linalg.inv(view)
    world_from_camera[:3, :3] = _orthonormal(world_from_camera[:3, :3])
    camera = core.Camera()
    camera.name = "viewport"
    camera.width_px, camera.height_px = size_px
    # Normalised device coordinates of the part: [left, right] x [bottom, top] within [-1, 1].
    left, bottom, right, top = (2.0 * edge - 1.0 for edge in part)
    perspective = bool(window[3, 3] == 0.0)
    across, up = float(window[0, 0]), float(window[1, 1])
    # ndc = across * x + offset, with x the tangent to the side or, orthographic, metres.
    offset_x, offset_y = (-window[0, 2], -window[1, 2]) if perspective else (window[0, 3], window[1, 3])
    half_width = (right - left) / (2.0 * across)
    centre_x = ((left + right) / 2.0 - offset_x) / across
    centre_y = ((bottom + top) / 2.0 - offset_y) / up
    camera.shift = (centre_x / (2.0 * half_width), centre_y / (2.0 * half_width))
    half_height = (top - bottom) / (2.0 * up)
    camera.pixel_aspect = (half_height / size_px[1]) / (half_width / size_px[0])
    camera.orthographic = not perspective
    near, far = _clip_range(window, perspective)
    if perspective:
        camera.tan_half_width = half_width
    else:
        camera.half_width_m = half_width
        # Blender's orthographic viewport sees behind its eye as well; ours steps back until all is before it.
        backwards = world_from_camera[:3, 2]
        heights = (box_points - world_from_camera[:3, 3]) @ backwards
        back = max(float(heights.max()) * _MARGIN, -near, 1e-3)
        world_from_camera[:3, 3] += backwards * back
        near, far = 1e-4 * max(back, 1.0), max(float(back - heights.min()) * _MARGIN, 1e-2)
    camera.world_from_camera = world_from_camera
    camera.near_m, camera.far_m = near, max(far, 2.0 * near)
    return camera


def _clip_range(window: DoubleArray, perspective: bool) -> tuple[float, float]:
    a, b = float(window[2, 2]), float(window[2, 3])
    if perspective:
        return b / (a - 1.0), b / (a + 1.0)
    return (b + 1.0) / a, (b - 1.0) / a


def _orthonormal(rotation: DoubleArray) -> DoubleArray:
    """The nearest rotation: Blender's matrices are float32."""
    u, _, v = np.linalg.svd(rotation)
    nearest: DoubleArray = u @ v
    return nearest
