"""Which part of a 3D viewport is to be rendered, and with what camera: the whole region, or a border within it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

from .transforms import DoubleArray
from .view_camera import view_camera


@dataclass(frozen=True)
class SeenPart:
    box: tuple[int, int, int, int]  # left, bottom, width, height in pixels of the region
    key: Hashable  # equal keys mean an equal camera
    camera: Callable[[tuple[int, int], DoubleArray], Any]  # (size in pixels, box points) -> core.Camera


def seen_part(context: Any) -> SeenPart | None:
    """None if there is nothing to render: a region without pixels, or a border outside of it."""
    region, view = context.region, context.region_data
    if region is None or view is None or region.width < 1 or region.height < 1:
        return None
    box = _border(context, region, view)
    if box is None:
        return None
    left, bottom, width, height = box
    part = (
        left / region.width,
        bottom / region.height,
        (left + width) / region.width,
        (bottom + height) / region.height,
    )
    view_matrix, window_matrix = view.view_matrix.copy(), view.window_matrix.copy()
    region_px = (region.width, region.height)

    def camera(size_px: tuple[int, int], box_points: DoubleArray) -> Any:
        import penumbra_core

        return view_camera(penumbra_core, view_matrix, window_matrix, size_px, box_points, part)

    numbers = tuple(x for matrix in (view_matrix, window_matrix) for row in matrix for x in row)
    return SeenPart(box, (region_px, box, numbers), camera)


def own_choice(space: Any | None) -> tuple[Any, ...]:
    """What a 3D viewport shows of the scene by its own choice: another value, another choice of objects.

    Within local view and local collections Blender tells of changes; of entering them and of types of objects it does
    not.
    """
    if space is None:
        return ()
    types = tuple(getattr(space, name) for name in _type_switches())
    return (space.local_view is not None, bool(space.use_local_collections), types)


def hides_something(space: Any | None) -> bool:
    """True if a viewport may show less than its view layer."""
    local, collections, types = own_choice(space) or (False, False, ())
    return local or collections or not all(types)


@functools.cache
def _type_switches() -> tuple[str, ...]:
    import bpy

    properties = (entry.identifier for entry in bpy.types.SpaceView3D.bl_rna.properties)
    return tuple(sorted(name for name in properties if name.startswith("show_object_viewport_")))


def _border(context: Any, region: Any, view: Any) -> tuple[int, int, int, int] | None:
    """The render border in pixels of the region; the whole region where none is set."""
    whole = (0, 0, region.width, region.height)
    scene, space = context.scene, context.space_data
    render = scene.render
    if view.view_perspective == "CAMERA":
        if not render.use_border or scene.camera is None:
            return whole
        frame = _camera_frame(scene, region, view)
        if frame is None:
            return whole
        left, bottom, right, top = frame
        across, up = right - left, top - bottom
        edges = (
            left + render.border_min_x * across,
            bottom + render.border_min_y * up,
            left + render.border_max_x * across,
            bottom + render.border_max_y * up,
        )
    elif space is not None and space.use_render_border:
        edges = (
            space.render_border_min_x * region.width,
            space.render_border_min_y * region.height,
            space.render_border_max_x * region.width,
            space.render_border_max_y * region.height,
        )
    else:
        return whole
    left_px, bottom_px = max(0, round(edges[0])), max(0, round(edges[1]))
    right_px, top_px = min(region.width, round(edges[2])), min(region.height, round(edges[3]))
    if right_px <= left_px or top_px <= bottom_px:
        return None
    return left_px, bottom_px, right_px - left_px, top_px - bottom_px


def _camera_frame(scene: Any, region: Any, view: Any) -> tuple[float, float, float, float] | None:
    """Left, bottom, right, top of the camera's frame in pixels of the region."""
    camera = scene.camera
    if camera.type != "CAMERA":
        return None
    corners = [camera.matrix_world.normalized() @ corner for corner in camera.data.view_frame(scene=scene)]
    points = []
    for corner in corners:
        clip = view.perspective_matrix @ corner.to_4d()
        if clip.w <= 0.0:
            return None
        points.append(((clip.x / clip.w + 1.0) / 2.0 * region.width, (clip.y / clip.w + 1.0) / 2.0 * region.height))
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs), min(ys), max(xs), max(ys)
