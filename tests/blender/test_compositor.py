"""The compositor in a real Blender: what the group of nodes puts into the saved picture, pixel for pixel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenEXR
import pytest
from blender_kit import Kit
from image_files import choose_multilayer_exr

WIDTH, HEIGHT = 64, 32
A, B = "shadow_map", "ray_traced"
NAMES = {A: "Visibility Hard shadow map", B: "Visibility Ray tracing", "": "Reference"}


@pytest.fixture
def scene(addon: Kit) -> Kit:
    """A floor from above, half of it in a shadow whose edge is soft along x and y."""
    addon.plane("Floor", half=20)
    addon.plane("Plate", half=0.35, at=(0.1, 0.1, 1)).visible_camera = False
    addon.light("AREA", name="Key", energy=100, at=(0, 0, 2), size=0.8)
    addon.camera(at=(0, 0, 1.5), type="ORTHO", ortho_scale=2, clip_start=0.6, clip_end=10)
    render = addon.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    addon.scene.penumbra.pixel_samples = 1
    addon.scene.penumbra.reference_error = 0.02
    addon.scene.view_settings.view_transform = "Standard"
    return addon


def saved(kit: Kit, path: Path) -> Any:
    """(h, w, 3) of the rendered still, row 0 at the bottom."""
    settings = kit.scene.render.image_settings
    if hasattr(settings, "media_type"):  # 5.0 and newer
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
    kit.scene.render.filepath = str(path)
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    return planes(path)["RGB"]


def planes(path: Path) -> dict[str, Any]:
    found = {}
    for part in OpenEXR.File(str(path)).parts:
        for name, channel in part.channels.items():
            found[name] = np.asarray(channel.pixels)[::-1]
    return found


@pytest.fixture
def truth(scene: Kit, tmp_path: Path) -> dict[str, Any]:
    """V of A and B and the reference, from a multilayer file without any compositing."""
    layer = scene.scene.view_layers[0].penumbra
    layer.visibility, layer.use_reference = {A, B}, True
    choose_multilayer_exr(scene.scene.render.image_settings)
    scene.scene.render.filepath = str(tmp_path / "truth.exr")
    bpy.ops.render.render(write_still=True)
    found = planes(tmp_path / "truth.exr")
    layer.visibility, layer.use_reference = set(), False
    return {key: found[f"ViewLayer.{name}.X"] for key, name in NAMES.items()}


def add(**given: Any) -> Any:
    assert bpy.ops.penumbra.compositor_compare(technique_a=A, technique_b=B, **given) == {"FINISHED"}
    return the_node()


def tree() -> Any:
    from penumbra import compat

    return compat.compositor_tree(bpy.context.scene, make=False)


def the_node() -> Any:
    (node,) = [node for node in tree().nodes if node.bl_idname == "CompositorNodeGroup"]
    return node


def test_left_of_the_wipe_is_a_and_right_of_it_b_to_the_last_bit(scene: Kit, truth: Any, tmp_path: Path) -> None:
    node = add()
    node.inputs["Position"].default_value = 0.375
    picture = saved(scene, tmp_path / "wipe.exr")
    line = round(0.375 * WIDTH)
    assert not np.array_equal(truth[A], truth[B])
    for channel in range(3):
        assert np.array_equal(picture[:, : line - 1, channel], truth[A][:, : line - 1])
        assert np.array_equal(picture[:, line + 1 :, channel], truth[B][:, line + 1 :])


@pytest.mark.parametrize(("position", "expected"), [(0.0, B), (1.0, A)])
def test_at_its_ends_the_wipe_shows_one_picture_alone(
    scene: Kit, truth: Any, tmp_path: Path, position: float, expected: str
) -> None:
    add().inputs["Position"].default_value = position
    picture = saved(scene, tmp_path / "wipe.exr")
    inner = np.s_[:, 1:-1]
    assert np.array_equal(picture[(*inner, 0)], truth[expected][inner])


def test_a_soft_edge_is_a_ramp_of_its_width(scene: Kit, truth: Any, tmp_path: Path) -> None:
    node = add()
    node.inputs["Position"].default_value, node.inputs["Softness"].default_value = 0.5, 0.25
    picture = saved(scene, tmp_path / "wipe.exr")[..., 0]
    x = (np.arange(WIDTH) + 0.5) / WIDTH
    share = np.clip((x - 0.5) / 0.25 + 0.5, 0, 1)
    expected = truth[A] * (1 - share) + truth[B] * share
    # 4.2 places a pixel by its left edge: half a pixel of a ramp over a quarter of the width.
    assert np.abs(picture - expected).max() <= 0.5 / (0.25 * WIDTH) + 1e-5
    assert np.array_equal(picture[:, : WIDTH // 4], truth[A][:, : WIDTH // 4])


def test_the_difference_is_the_distance_of_a_and_b_times_the_scale(scene: Kit, truth: Any, tmp_path: Path) -> None:
    node = add(show="Difference")
    node.inputs["Difference Scale"].default_value = 3.0
    picture = saved(scene, tmp_path / "difference.exr")[..., 0]
    assert np.allclose(picture, 3 * np.abs(truth[A] - truth[B]), atol=1e-6)
    assert picture.max() > 0.3


def test_false_colours_are_the_reports_on_each_side_of_the_line(scene: Kit, truth: Any, tmp_path: Path) -> None:
    from penumbra import images

    add(show="False Colour").inputs["Position"].default_value = 0.5
    picture = saved(scene, tmp_path / "colours.exr")
    half = WIDTH // 2
    wiped = np.concatenate([truth[A][:, :half], truth[B][:, half:]], axis=1)
    expected = images.false_colour(wiped - truth[""], np.ones(wiped.shape, np.uint8))
    shown = images.srgb_bytes(picture)
    away = np.abs(np.arange(WIDTH) + 0.5 - half) > 1
    difference = np.abs(shown.astype(int) - expected.astype(int))[:, away]
    # Blender blends its 32 stops in linear light, the report in sRGB.
    assert difference.max() <= 6 and difference.mean() < 1


def test_it_switches_on_the_passes_the_nodes_and_compositing(scene: Kit) -> None:
    scene.scene.render.use_compositing = False
    assert tree() is None
    add()
    chosen = scene.scene.view_layers[0].penumbra
    assert chosen.visibility == {A, B} and chosen.use_reference
    assert scene.scene.render.use_compositing
    sources = {link.to_socket.name: link.from_socket.name for link in tree().links if link.to_node == the_node()}
    assert sources == {"A": NAMES[A], "B": NAMES[B], "Reference": NAMES[""]}


def test_run_twice_it_rewires_and_doubles_nothing(scene: Kit) -> None:
    add()
    before = (len(tree().nodes), len(tree().links), len(bpy.data.node_groups), len(bpy.data.textures))
    the_node().inputs["Position"].default_value = 0.2
    add()
    assert (len(tree().nodes), len(tree().links), len(bpy.data.node_groups), len(bpy.data.textures)) == before
    assert the_node().inputs["Position"].default_value == pytest.approx(0.2), "what the artist set stays"
    bpy.ops.penumbra.compositor_compare(technique_a="pcf", technique_b=B, show="Difference")
    assert (len(tree().nodes), len(tree().links)) == before[:2]
    assert scene.scene.view_layers[0].penumbra.visibility == {A, B, "pcf"}


def test_a_picture_of_the_artists_own_at_the_output_stays(scene: Kit) -> None:
    from penumbra import compat

    nodes = compat.compositor_tree(scene.scene, make=True)
    own = nodes.nodes.new("CompositorNodeBlur")
    target = compat.compositor_output(nodes)
    nodes.links.new(own.outputs[0], target)
    add()
    assert compat.compositor_output(nodes).links[0].from_node == own
    assert len([node for node in nodes.nodes if node.bl_idname == target.node.bl_idname]) == 1


def test_with_a_pass_for_each_light_those_of_the_light_are_taken(scene: Kit) -> None:
    scene.light("POINT", name="Fill", energy=10, at=(1, 1, 2))
    scene.scene.view_layers[0].penumbra.per_light = True
    add(light="Key")
    links = {link.to_socket.name: link.from_socket.name for link in tree().links if link.to_node == the_node()}
    assert links == {"A": f"{NAMES[A]} Key", "B": f"{NAMES[B]} Key", "Reference": "Reference Key"}
    add()
    links = {link.to_socket.name: link.from_socket.name for link in tree().links if link.to_node == the_node()}
    assert links["A"] == f"{NAMES[A]} Fill", "the first by name"


def test_undo_takes_it_away(scene: Kit) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.penumbra.compositor_compare("EXEC_DEFAULT", True, technique_a=A, technique_b=B)
    assert tree() is not None and "Penumbra Compare" in bpy.data.node_groups
    bpy.ops.ed.undo()
    assert "Penumbra Compare" not in bpy.data.node_groups
    assert bpy.context.scene.view_layers[0].penumbra.visibility == set()


def test_another_engine_has_no_such_passes_and_it_says_so(scene: Kit) -> None:
    scene.scene.render.engine = "CYCLES"
    with pytest.raises(RuntimeError, match="choose it first"):
        bpy.ops.penumbra.compositor_compare()
