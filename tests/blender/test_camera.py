"""The exported camera maps world points to the pixels to which Blender maps them."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from blender_kit import Kit, bpy
from penumbra import scenes
from penumbra.read.cameras import read_frame, read_lens


def pixels(camera: Any, points: Any) -> Any:
    """Where the core's camera sees world points: (n, 2) in pixels from the picture's lower left corner."""
    world_from_camera = np.array(camera.world_from_camera)
    local = (np.asarray(points) - world_from_camera[:3, 3]) @ world_from_camera[:3, :3]
    depth = np.ones(len(local)) if camera.orthographic else -local[:, 2]
    half = camera.half_width_m if camera.orthographic else camera.tan_half_width
    # Picture widths from the picture's centre.
    x = local[:, 0] / depth / (2 * half) - camera.shift[0]
    y = local[:, 1] / depth / (2 * half) - camera.shift[1]
    width, height = camera.width_px, camera.height_px
    return np.column_stack((width * (x + 0.5), width * y / camera.pixel_aspect + height / 2))


def random_camera(kit: Kit, rng: random.Random, longest_px: int) -> Any:
    obj = kit.camera(
        at=[rng.uniform(-5, 5) for _ in range(3)],
        turn=[rng.uniform(-math.pi, math.pi) for _ in range(3)],
        type=rng.choice(("PERSP", "PERSP", "ORTHO")),
        sensor_fit=rng.choice(("AUTO", "HORIZONTAL", "VERTICAL")),
    )
    obj.data.lens = rng.uniform(8, 200)
    obj.data.sensor_width, obj.data.sensor_height = rng.uniform(5, 60), rng.uniform(5, 60)
    obj.data.ortho_scale = rng.uniform(0.1, 20)
    obj.data.shift_x, obj.data.shift_y = rng.uniform(-1, 1), rng.uniform(-1, 1)
    if rng.random() < 0.3:
        obj.scale = [rng.uniform(0.2, 3) * rng.choice((1, 1, -1)) for _ in range(3)]
    render = kit.scene.render
    render.resolution_x, render.resolution_y = rng.randint(4, longest_px), rng.randint(4, longest_px)
    render.resolution_percentage = rng.choice((100, 100, 50, 37, 150))
    render.pixel_aspect_x, render.pixel_aspect_y = rng.choice(((1, 1), (1, 1), (1.5, 1), (1, 1.25)))
    return obj


def points_before(obj: Any, rng: random.Random, count: int = 12) -> Any:
    """Points in front of the camera, near its axis."""
    matrix = np.array(obj.matrix_world.normalized())
    local = np.array([(rng.uniform(-1, 1), rng.uniform(-1, 1), -rng.uniform(2, 9)) for _ in range(count)])
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def largest_error(kit: Kit, rng: random.Random) -> float:
    """Against world_to_camera_view, relative to the coordinate or the picture's longer side."""
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    obj = random_camera(kit, rng, 4000)
    # It takes the picture's shape before the percentage has rounded it.
    kit.scene.render.resolution_percentage = 100
    bpy.context.view_layer.update()
    camera = kit.read().scene.camera
    points = points_before(obj, rng)
    seen = [world_to_camera_view(kit.scene, obj, Vector(p)) for p in points]
    return relative(pixels(camera, points), np.array([(v.x, v.y) for v in seen]) * (camera.width_px, camera.height_px))


def relative(ours: Any, theirs: Any) -> float:
    """The largest difference over the largest coordinate: Blender computes in single precision."""
    return float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1.0))


def blender_pixels(kit: Kit, obj: Any, points: Any) -> Any:
    """The same from Blender's own projection matrix, multiplied out in double precision."""
    render = kit.scene.render
    frame = read_frame(kit.scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = np.array(
        obj.calc_matrix_camera(
            depsgraph,
            x=frame.width,
            y=frame.height,
            scale_x=render.pixel_aspect_x,
            scale_y=render.pixel_aspect_y,
        ),
        dtype=np.float64,
    )
    view = np.linalg.inv(np.array(obj.matrix_world.normalized(), dtype=np.float64))
    clip = np.column_stack((points, np.ones(len(points)))) @ view.T @ projection.T
    return (clip[:, :2] / clip[:, 3:] + 1) / 2 * (frame.width, frame.height)


def test_small_pictures_agree_with_blender_to_1e_5_pixels(kit: Kit) -> None:
    rng = random.Random(1)
    worst = 0.0
    for _ in range(150):
        obj = random_camera(kit, rng, 64)
        obj.data.shift_x *= 0.2
        obj.data.shift_y *= 0.2
        obj.data.lens = rng.uniform(8, 50)
        obj.data.sensor_width, obj.data.sensor_height = rng.uniform(20, 60), rng.uniform(20, 60)
        kit.scene.render.resolution_x = rng.randint(16, 64)
        kit.scene.render.resolution_y = kit.scene.render.resolution_x * rng.choice((1, 2)) // rng.choice((1, 2))
        kit.scene.render.resolution_percentage = 100
        obj.scale = (1, 1, 1)
        bpy.context.view_layer.update()
        points = points_before(obj, rng)
        camera = kit.read().scene.camera
        theirs = blender_pixels(kit, obj, points)
        inside = ((theirs > 0) & (theirs < (camera.width_px, camera.height_px))).all(axis=1)
        if inside.any():
            worst = max(worst, float(np.abs(pixels(camera, points) - theirs)[inside].max()))
        bpy.data.objects.remove(obj)
    assert worst < 1e-5


def test_random_cameras_agree_with_world_to_camera_view_within_single_precision(kit: Kit) -> None:
    rng = random.Random(2)
    # It reads the frame's corners as single-precision vectors first, which costs a few more bits than the matrix.
    assert max(largest_error(kit, rng) for _ in range(150)) < 5e-6


def test_random_cameras_and_percentages_agree_with_blenders_matrix_within_single_precision(kit: Kit) -> None:
    rng = random.Random(5)
    worst = 0.0
    for _ in range(150):
        obj = random_camera(kit, rng, 4000)
        bpy.context.view_layer.update()
        camera = kit.read().scene.camera
        points = points_before(obj, rng)
        worst = max(worst, relative(pixels(camera, points), blender_pixels(kit, obj, points)))
    assert worst < 1e-6


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_render_border_keeps_every_pixel_where_it_was(kit: Kit, kind: str) -> None:
    rng = random.Random(3)
    kit.camera(type=kind, shift_x=0.1, shift_y=-0.2)
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = 301, 203
    kit.scene.render.pixel_aspect_y = 1.3
    bpy.context.view_layer.update()
    points = points_before(kit.scene.camera, rng)
    whole = pixels(kit.read().scene.camera, points)
    render = kit.scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x = 0.2, 0.71
    render.border_min_y, render.border_max_y = 0.37, 0.9
    export = kit.read()
    left, bottom, right, top = (60, 75, 213, 182)
    assert export.size == (right - left, top - bottom)
    corner = np.array((left, bottom))
    np.testing.assert_allclose(pixels(export.scene.camera, points) + corner, whole, atol=1e-9)


def test_the_border_is_rounded_as_blender_rounds_it(kit: Kit, tmp_path: Any) -> None:
    kit.camera()
    render = kit.scene.render
    render.engine = "CYCLES"
    kit.scene.cycles.samples = 1
    render.use_border = render.use_crop_to_border = True
    rng = random.Random(4)
    for i in range(12):
        render.resolution_x, render.resolution_y = rng.randint(20, 90), rng.randint(20, 90)
        render.border_min_x, render.border_max_x = rng.uniform(0, 0.4), rng.uniform(0.5, 1)
        render.border_min_y, render.border_max_y = rng.uniform(0, 0.4), rng.uniform(0.5, 1)
        render.filepath = str(tmp_path / f"border{i}.png")
        with scenes.quiet():
            bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath)
        assert read_frame(kit.scene).size == tuple(image.size)


def test_a_size_replaces_resolution_and_percentage(kit: Kit) -> None:
    kit.camera()
    kit.scene.render.resolution_percentage = 25
    assert kit.read(size=(320, 200)).size == (320, 200)


def test_a_size_below_one_pixel_is_one_sentence(kit: Kit) -> None:
    kit.camera()
    with pytest.raises(scenes.SceneError, match="0 x 20 pixels"):
        kit.read(size=(0, 20))


def test_clipping_distances_are_kept(kit: Kit) -> None:
    kit.camera(clip_start=0.25, clip_end=77)
    camera = kit.read().scene.camera
    assert (camera.near_m, camera.far_m) == (0.25, 77)


def test_the_sensor_height_counts_only_where_the_fit_is_vertical(kit: Kit) -> None:
    obj = kit.camera(sensor_width=36, sensor_height=10, lens=50)
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = 100, 200
    frame = read_frame(kit.scene)
    assert read_lens(obj.data, frame).half_width == pytest.approx(0.36 / 2)
    obj.data.sensor_fit = "VERTICAL"
    assert read_lens(obj.data, frame).half_width == pytest.approx(0.1 / 2)


def test_a_camera_is_chosen_by_name(kit: Kit) -> None:
    kit.camera("First", at=(1, 0, 9))
    kit.camera("Second", at=(2, 0, 9))
    export = kit.read(camera="First")
    assert export.camera == "First"
    assert export.scene.camera.world_from_camera[0][3] == 1.0


def test_an_unknown_camera_is_one_sentence_that_lists_the_others(kit: Kit) -> None:
    kit.camera("First")
    with pytest.raises(scenes.SceneError, match='no camera called "Third"; the scene has "First"'):
        kit.read(camera="Third")


def test_a_panorama_is_replaced_and_noted(kit: Kit) -> None:
    kit.camera(type="PANO")
    export = kit.read()
    assert any("projection is replaced by a perspective one" in note for note in export.notes)


def test_depth_of_field_is_noted(kit: Kit) -> None:
    kit.camera().data.dof.use_dof = True
    assert any("depth of field is ignored" in note for note in kit.read().notes)


def test_a_camera_flattened_by_its_scale_is_one_sentence(kit: Kit) -> None:
    kit.camera().scale = (1, 0, 1)
    with pytest.raises(scenes.SceneError, match="flattens it"):
        kit.read()


def test_a_camera_bound_to_a_marker_serves_its_frame(kit: Kit) -> None:
    second = kit.camera("Second")
    first = kit.camera("First")
    for frame, camera in ((1, first), (10, second)):
        kit.scene.timeline_markers.new(camera.name, frame=frame).camera = camera
    assert kit.read(frame=1).camera == "First"
    assert kit.read(frame=12).camera == "Second"


@pytest.mark.parametrize("size", [(640, 360), (200, 600)])
def test_a_placed_camera_frames_everything_and_is_noted(kit: Kit, size: tuple[int, int]) -> None:
    kit.cube("A", at=(3, 40, 1))
    kit.cube("B", at=(-7, 2, 30), scale=(4, 1, 1))
    export = kit.read(size=size)
    assert any("no camera" in note for note in export.notes)
    low = np.array([(2, 39, 0), (4, 41, 2), (-11, 1, 29), (-3, 3, 31)], dtype=float)
    seen = pixels(export.scene.camera, low)
    assert (seen > 0).all() and (seen < size).all()
    local = (low - np.array(export.scene.camera.world_from_camera)[:3, 3]) @ np.array(
        export.scene.camera.world_from_camera
    )[:3, :3]
    assert (-local[:, 2] > export.scene.camera.near_m).all() and (-local[:, 2] < export.scene.camera.far_m).all()


def test_a_placed_camera_leaves_nothing_behind(kit: Kit) -> None:
    kit.cube()
    kit.read()
    assert kit.scene.camera is None
    assert not bpy.data.cameras
    assert [o.name for o in bpy.data.objects] == ["Cube"]
