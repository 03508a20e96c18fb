"""Which part of a viewport is rendered: the whole region, a border drawn in it, or the camera's border in its view.

RegionView3D's matrices are set when Blender draws; here they are made by hand from a camera's own.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from blender_kit import Kit
from mathutils import Matrix
from penumbra import bridge
from penumbra.read import view_region

RENDER = (120, 80)
REGION = (400, 300)


def camera_view(kit: Kit, zoom: float, offset: tuple[float, float]) -> Any:
    """What Blender hands to view_draw in a camera view: the camera's frame is `zoom` of the region's width, its centre
    `offset` beside the region's, in regions."""
    scene, camera = kit.scene, kit.scene.camera
    depsgraph = bpy.context.evaluated_depsgraph_get()
    window = camera.calc_matrix_camera(depsgraph, x=RENDER[0], y=RENDER[1])
    # From the camera's frame to the region: scaled to the frame's size in it, then moved.
    high = zoom * REGION[0] * RENDER[1] / RENDER[0] / REGION[1]
    place = Matrix.Diagonal((zoom, high, 1.0, 1.0))
    place[0][3], place[1][3] = 2.0 * offset[0], 2.0 * offset[1]
    window = place @ window
    view = camera.matrix_world.normalized().inverted()
    data = SimpleNamespace(
        view_matrix=view, window_matrix=window, perspective_matrix=window @ view, view_perspective="CAMERA"
    )
    return SimpleNamespace(
        scene=scene,
        region=SimpleNamespace(width=REGION[0], height=REGION[1]),
        region_data=data,
        space_data=SimpleNamespace(use_render_border=False),
    )


@pytest.fixture
def furnished(kit: Kit) -> Kit:
    kit.plane("Floor", half=5)
    kit.light("POINT", at=(0, 0, 4))
    render = kit.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = *RENDER, 100
    return kit


def points_seen(camera: Any, at: Any) -> Any:
    """Where pixels' places `at` (n, 2), 0 .. 1 of the picture, hit the plane z = 0."""
    matrix = np.asarray(camera.world_from_camera, np.float64)
    share = np.asarray(at, np.float64) - 0.5
    high = camera.height_px / camera.width_px * camera.pixel_aspect
    x = share[:, 0] + camera.shift[0]
    y = share[:, 1] * high + camera.shift[1]
    if camera.orthographic:
        starts = (
            np.column_stack((x, y, np.zeros(len(x)))) * 2.0 * camera.half_width_m @ matrix[:3, :3].T + matrix[:3, 3]
        )
        rays = np.broadcast_to(-matrix[:3, 2], starts.shape)
    else:
        local = np.column_stack((x * 2.0 * camera.tan_half_width, y * 2.0 * camera.tan_half_width, -np.ones(len(x))))
        rays = local @ matrix[:3, :3].T
        starts = np.broadcast_to(matrix[:3, 3], rays.shape)
    return starts - rays * (starts[:, 2] / rays[:, 2])[:, None]


CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5], [0.3, 0.8]])


@pytest.mark.parametrize("kind", [{"lens": 40.0}, {"type": "ORTHO", "ortho_scale": 5.0}], ids=["lens", "ortho"])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.25, -0.15)])
@pytest.mark.parametrize("border", [None, (0.25, 0.75, 0.1, 0.6)])
def test_in_a_camera_view_the_viewport_sees_what_the_render_sees(
    furnished: Kit, kind: dict[str, Any], shift: tuple[float, float], border: tuple[float, ...] | None
) -> None:
    """Camera, shift, zoom of the view and render border: at each place of the picture the same point of the floor."""
    kit = furnished
    kit.camera(at=(0.5, -2, 6), turn=(0.4, 0.1, 0.2), shift_x=shift[0], shift_y=shift[1], **kind)
    render = kit.scene.render
    if border:
        render.use_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    bpy.context.view_layer.update()
    rendered = bridge.read_scene(bpy.context.evaluated_depsgraph_get()).scene.camera
    zoom, offset = 0.6, (0.05, -0.1)
    seen = view_region.seen_part(camera_view(kit, zoom, offset))
    assert seen is not None
    width, height = seen.box[2:]
    if not border:
        assert seen.box == (0, 0, *REGION), "all of the region, the camera's surroundings too"
        # The camera's frame in the region.
        frame = (zoom * REGION[0], zoom * REGION[0] * RENDER[1] / RENDER[0])
        low = (REGION[0] * (0.5 + offset[0]) - frame[0] / 2, REGION[1] * (0.5 + offset[1]) - frame[1] / 2)
        places = (np.array(low) + CORNERS * frame) / REGION
    else:
        places = CORNERS
        share = (width / (zoom * REGION[0]), height / (zoom * REGION[0] * RENDER[1] / RENDER[0]))
        assert share == pytest.approx((border[1] - border[0], border[3] - border[2]), abs=0.01)
    made = seen.camera((width, height), np.array([[-5.0, -5, 0], [5, 5, 0]]))
    pixel = 2.0 * float(np.linalg.norm(np.diff(points_seen(made, [[0.5, 0.5], [0.5 + 1 / width, 0.5]]), axis=0)))
    assert np.abs(points_seen(made, places) - points_seen(rendered, CORNERS)).max() < (pixel if border else 1e-4)


def test_a_border_drawn_in_a_viewport_is_its_part_of_the_region(furnished: Kit) -> None:
    furnished.camera(at=(0, 0, 6))
    bpy.context.view_layer.update()
    context = camera_view(furnished, 1.0, (0, 0))
    context.region_data.view_perspective = "PERSP"
    assert view_region.seen_part(context).box == (0, 0, *REGION)
    space = SimpleNamespace(
        use_render_border=True,
        render_border_min_x=0.25, render_border_max_x=0.5, render_border_min_y=0.1, render_border_max_y=0.9,
    )  # fmt: skip
    context.space_data = space
    assert view_region.seen_part(context).box == (100, 30, 100, 240)
    space.render_border_max_x = 0.25
    assert view_region.seen_part(context) is None, "nothing is left to render"


def test_a_border_beside_the_region_leaves_nothing_to_render(furnished: Kit) -> None:
    furnished.camera(at=(0, 0, 6))
    render = furnished.scene.render
    render.use_border, render.border_min_x, render.border_max_x = True, 0.0, 0.2
    bpy.context.view_layer.update()
    assert view_region.seen_part(camera_view(furnished, 1.0, (-0.4, 0))) is None
    assert view_region.seen_part(camera_view(furnished, 1.0, (0, 0))).box[2] == pytest.approx(80, abs=1)
