"""The render engine in a real Blender, in the background: pictures, passes, animations, errors, switching off."""

from __future__ import annotations

import gc
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenEXR
import penumbra
import pytest
from blender_kit import Kit
from image_files import choose_multilayer_exr

WIDTH, HEIGHT = 48, 32


def small(kit: Kit, width: int = WIDTH, height: int = HEIGHT) -> None:
    render = kit.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    kit.scene.penumbra.pixel_samples = 1


def multilayer(kit: Kit, path: Path) -> dict[str, Any]:
    """Renders, saves every pass and reads it back: name to array, row 0 at the bottom."""
    choose_multilayer_exr(kit.scene.render.image_settings)
    kit.scene.render.filepath = str(path)
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    planes: dict[str, Any] = {}
    for part in OpenEXR.File(str(path)).parts:
        for name, channel in part.channels.items():
            planes[name] = np.asarray(channel.pixels)[::-1]
    return planes


def edge_scene(kit: Kit) -> None:
    """A floor seen from above; a point light in its middle; a blocker over the half x > 0."""
    kit.plane("Floor", half=20)
    kit.mesh("Blocker", [(0, -9, 1), (9, -9, 1), (9, 9, 1), (0, 9, 1)], [(0, 1, 2, 3)])
    kit.light("POINT", energy=100, at=(0, 0, 2))
    kit.camera(at=(0, 0, 1.5), type="ORTHO", ortho_scale=2, clip_start=0.6, clip_end=10)
    bpy.data.objects["Blocker"].visible_camera = False
    small(kit)


def test_a_lit_floor_has_the_radiance_of_the_closed_form_and_its_shadow_none(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    planes = multilayer(addon, tmp_path / "a.exr")
    colour = planes["ViewLayer.Combined"]
    assert colour.shape == (HEIGHT, WIDTH, 4)
    assert np.all(colour[..., 3] == 1)
    assert np.all(colour[:, WIDTH // 2 + 1 :, :3] == 0)
    x = (np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1
    y = ((np.arange(HEIGHT) + 0.5) / HEIGHT * 2 - 1) * HEIGHT / WIDTH
    squared = x[None, :] ** 2 + y[:, None] ** 2 + 4
    # Irradiance I cos / d^2 with Blender's I = P / (4 pi), cos = 2 / d; the floor is grey, 0.8.
    expected = 100 / (4 * math.pi) / squared * 2 / np.sqrt(squared) * 0.8 / math.pi
    lit = np.s_[:, : WIDTH // 2 - 1]
    assert np.allclose(colour[(*lit, 0)], expected[lit], rtol=1e-5)


def test_every_pass_arrives_and_the_error_is_visibility_less_reference(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    addon.light("POINT", name="Fill", energy=10, at=(-1, 0.5, 3), shadow_soft_size=0.4)
    layer = addon.scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
    layer.penumbra.visibility = {"shadow_map", "pcf"}
    layer.penumbra.use_reference = layer.penumbra.use_error = True
    addon.scene.penumbra.reference_error = 0.05
    planes = multilayer(addon, tmp_path / "a.exr")
    hard, truth = planes["ViewLayer.Visibility Hard shadow map.X"], planes["ViewLayer.Reference.X"]
    assert 0 <= truth.min() < 0.1 and truth.max() == 1
    assert np.array_equal(planes["ViewLayer.Error Hard shadow map.X"], hard - truth)
    assert len([name for name in planes if name.startswith("ViewLayer.Error")]) == 2
    assert np.allclose(planes["ViewLayer.Depth.Z"], 1.5, atol=1e-4)
    assert np.allclose(planes["ViewLayer.Normal.Z"], 1, atol=1e-6)
    assert np.allclose(planes["ViewLayer.Position.Z"], 0, atol=1e-6)
    assert np.ptp(planes["ViewLayer.Position.X"]) == pytest.approx(2 * (WIDTH - 1) / WIDTH, rel=1e-3)

    layer.penumbra.per_light = True
    planes = multilayer(addon, tmp_path / "b.exr")
    each = [planes[f"ViewLayer.Visibility Hard shadow map {light}.X"] for light in ("Fill", "Light")]
    assert np.array_equal(each[0] * each[1], hard)
    assert not np.array_equal(each[0], each[1])


def test_names_of_passes_fit_and_differ_however_long_the_lights_names_are(addon: Kit) -> None:
    from penumbra import passes

    layer = addon.scene.view_layers[0]
    layer.penumbra.visibility = {"shadow_map"}
    layer.penumbra.per_light = True
    lights = ["ä" * 31 + "a", "ä" * 31 + "b", "Key"]
    names = [entry.name for entry in passes.pass_list(layer, lights)]
    assert len(set(names)) == 3
    assert all(len(name.encode()) < 64 for name in names)


def test_each_view_layer_is_rendered_by_itself_and_a_disabled_one_is_not(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    scene = addon.scene
    away = bpy.data.collections.new("Blockers")
    scene.collection.children.link(away)
    blocker = bpy.data.objects["Blocker"]
    scene.collection.objects.unlink(blocker)
    away.objects.link(blocker)
    bare = scene.view_layers.new("Bare")
    bare.layer_collection.children["Blockers"].exclude = True
    scene.view_layers.new("Idle").use = False
    planes = multilayer(addon, tmp_path / "a.exr")
    assert planes["ViewLayer.Combined"][..., 0].min() == 0
    assert planes["Bare.Combined"][..., 0].min() > 0
    assert not any(name.startswith("Idle") for name in planes)


@pytest.mark.parametrize("crop", [False, True])
def test_a_border_holds_the_pixels_of_the_whole_picture(addon: Kit, tmp_path: Path, crop: bool) -> None:
    edge_scene(addon)
    whole = multilayer(addon, tmp_path / "whole.exr")["ViewLayer.Combined"]
    render = addon.scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    part = multilayer(addon, tmp_path / "part.exr")["ViewLayer.Combined"]
    inside = np.s_[HEIGHT // 2 :, WIDTH // 4 : 3 * WIDTH // 4]
    if crop:
        assert part.shape[:2] == (HEIGHT // 2, WIDTH // 2)
    else:
        assert part.shape[:2] == (HEIGHT, WIDTH)
        part = part[inside]
    assert np.allclose(part, whole[inside], atol=1e-4)


def test_the_resolution_percentage_counts(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    addon.scene.render.resolution_percentage = 50
    assert multilayer(addon, tmp_path / "a.exr")["ViewLayer.Combined"].shape[:2] == (HEIGHT // 2, WIDTH // 2)


def test_a_marker_switches_the_camera(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    first = multilayer(addon, tmp_path / "a.exr")["ViewLayer.Combined"]
    marker = addon.scene.timeline_markers.new("cut", frame=5)
    near = addon.scene.camera
    marker.camera = addon.camera("Other", at=(3, 0, 1.5), type="ORTHO", ortho_scale=2, clip_start=0.6)
    addon.scene.camera = near
    addon.scene.frame_set(5)
    second = multilayer(addon, tmp_path / "b.exr")["ViewLayer.Combined"]
    assert addon.scene.camera.name == "Other"
    assert first[..., 0].max() > 0 and second[..., 0].max() == 0, "the other camera sees only shadow"


def test_more_pixel_samples_smooth_the_edge(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    bpy.data.objects["Blocker"].rotation_euler = (0, 0, 0.3)
    addon.scene.view_layers[0].penumbra.visibility = {"shadow_map"}
    name = "ViewLayer.Visibility Hard shadow map.X"
    hard = multilayer(addon, tmp_path / "a.exr")[name]
    assert set(np.unique(hard)) == {0, 1}
    addon.scene.penumbra.pixel_samples = 8
    smooth = multilayer(addon, tmp_path / "b.exr")[name]
    partly = (smooth > 0) & (smooth < 1)
    assert HEIGHT // 2 < partly.sum() < 4 * HEIGHT
    assert np.allclose(smooth * 8, np.rint(smooth * 8), atol=1e-5)


def test_where_nothing_is_seen_the_world_shows_or_nothing(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    bpy.data.objects["Floor"].scale = (0.02, 0.02, 1)
    world = addon.scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.4, 1)
    corner = multilayer(addon, tmp_path / "a.exr")["ViewLayer.Combined"][0, 0]
    assert corner == pytest.approx([0.1, 0.2, 0.4, 1])
    addon.scene.render.film_transparent = True
    clear = multilayer(addon, tmp_path / "b.exr")["ViewLayer.Combined"]
    assert np.all(clear[0, 0] == 0)
    assert np.all(clear[HEIGHT // 2, WIDTH // 2 - 2, 3] == 1)


def test_an_error_ends_as_a_sentence_and_saves_nothing(
    addon: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edge_scene(addon)
    monkeypatch.setenv("PENUMBRA_DEVICE", "a device of nobody")
    addon.scene.render.filepath = str(tmp_path / "a.png")
    with pytest.raises(RuntimeError, match="no device matches"):
        bpy.ops.render.render(write_still=True)
    addon.scene.frame_end = 3
    with pytest.raises(RuntimeError, match="no device matches"):
        bpy.ops.render.render(animation=True)
    assert list(tmp_path.iterdir()) == []
    monkeypatch.delenv("PENUMBRA_DEVICE")
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}, "the next one works"


def test_a_core_that_does_not_load_is_an_error_of_the_render_and_not_of_the_add_on(
    addon: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from penumbra import native
    from penumbra.errors import UserError

    def gone() -> Any:
        raise UserError("the compiled module penumbra_core cannot be loaded in Python 3.99")

    edge_scene(addon)
    monkeypatch.setattr(native, "load", gone)
    with pytest.raises(RuntimeError, match=r"cannot be loaded in Python 3\.99"):
        bpy.ops.render.render()


def test_escape_ends_the_render_and_the_next_one_works(addon: Kit, monkeypatch: pytest.MonkeyPatch) -> None:
    from penumbra import engine, session

    edge_scene(addon)
    addon.scene.penumbra.technique = "ray_traced"
    addon.scene.penumbra.settings.ray_traced.rays = 65536
    bpy.data.lights["Light"].shadow_soft_size = 0.5
    small(addon, 960, 640)
    asked = []

    def escape(self: Any) -> bool:
        asked.append(1)
        return len(asked) > 2

    monkeypatch.setattr(engine.PENUMBRA_RE_engine, "_escaped", escape)
    bpy.ops.render.render()
    assert 2 < len(asked) < 10, "nothing goes on after the key"
    assert session.count()[1] == 0
    monkeypatch.undo()
    addon.scene.penumbra.technique = "shadow_map"
    assert bpy.ops.render.render() == {"FINISHED"}


def lit_shares(scene: bpy.types.Scene, folder: Path) -> list[float]:
    """Renders the animation; the share of each frame's pixels that are lit, first frame first."""
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(folder / "frame_####")
    assert bpy.ops.render.render(animation=True) == {"FINISHED"}
    shares = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        channels = OpenEXR.File(str(folder / f"frame_{frame:04}.exr")).channels()
        pixels = np.asarray(next(iter(channels.values())).pixels)
        shares.append(float((pixels[..., 0] > 0).mean()))
    return shares


def test_an_animation_renders_every_frame_with_one_renderer(addon: Kit, tmp_path: Path) -> None:
    from penumbra import session

    edge_scene(addon)
    scene = addon.scene
    scene.frame_start, scene.frame_end = 1, 4
    blocker = bpy.data.objects["Blocker"]
    for frame, x in ((1, 0.0), (4, 0.4)):
        blocker.location.x = x
        blocker.keyframe_insert("location", index=0, frame=frame)
    lit = lit_shares(scene, tmp_path)
    assert lit == sorted(lit) and lit[0] < lit[-1], "the shadow moves away"
    assert session.count() == (1, 0)
    session.release()
    assert session.count() == (0, 0)


def test_forty_renders_do_not_grow_the_process(addon: Kit) -> None:
    edge_scene(addon)

    def resident_mb() -> float:
        gc.collect()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * 4096 / 2**20

    sizes = []
    for number in range(40):
        addon.scene.render.resolution_x = WIDTH + number % 7
        bpy.ops.render.render()
        sizes.append(resident_mb())
    assert sizes[-1] - sizes[9] < 50


def test_settings_are_saved_in_the_file(addon: Kit, tmp_path: Path) -> None:
    addon.scene.penumbra.technique = "pcf"
    addon.scene.penumbra.settings.pcf.map_size = 333
    addon.scene.view_layers[0].penumbra.visibility = {"pcf", "ray_traced"}
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert bpy.context.scene.penumbra.technique == "shadow_map"
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert (scene.penumbra.technique, scene.penumbra.settings.pcf.map_size) == ("pcf", 333)
    assert scene.view_layers[0].penumbra.visibility == {"pcf", "ray_traced"}
    assert scene.render.engine == "PENUMBRA"


def test_every_setting_of_the_core_has_a_property_with_its_default_and_its_range(addon: Kit) -> None:
    import penumbra_core as core
    from penumbra import properties

    for info in core.techniques():
        defaults = {setting["id"]: setting["default"] for setting in info["settings"]}
        assert properties.settings_of(addon.scene, info["id"]) == pytest.approx(defaults)
        group = getattr(addon.scene.penumbra.settings, info["id"])
        for setting in info["settings"]:
            declared = group.bl_rna.properties[setting["id"]]
            assert declared.description
            if setting["type"] in ("int", "float"):
                assert declared.hard_min == pytest.approx(setting["minimum"])
                assert declared.hard_max == pytest.approx(setting["maximum"])


def test_the_catalogue_is_the_cores() -> None:
    import penumbra_core as core
    from penumbra import catalogue

    file = Path(penumbra.__file__).with_name(catalogue.FILE)
    assert file.read_text(encoding="utf-8") == catalogue.written(core), "run tools/make_stubs"


def test_switching_on_and_off_leaves_nothing_behind(kit: Kit) -> None:
    def traces() -> set[str]:
        found = {name for name in dir(bpy.types) if "PENUMBRA" in name}
        found |= {
            f"{owner.__name__}.penumbra"
            for owner in (bpy.types.Scene, bpy.types.ViewLayer)
            if hasattr(owner, "penumbra")
        }
        for name in dir(bpy.types):
            if "PENUMBRA" in getattr(getattr(bpy.types, name, None), "COMPAT_ENGINES", ()):
                found.add(name)
        return found

    assert traces() == set()
    for _ in range(3):
        penumbra.register()
        assert {"Scene.penumbra", "PENUMBRA_PT_technique"} <= traces()
        penumbra.unregister()
        assert traces() == set()


def test_blender_ends_by_itself_with_the_add_on_still_on(tmp_path: Path) -> None:
    script = (
        "import bpy, penumbra; penumbra.register(); bpy.context.scene.render.engine = 'PENUMBRA';"
        "bpy.context.scene.render.resolution_percentage = 5; bpy.ops.render.render(); print('rendered')"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert "rendered" in ran.stdout
    assert ran.returncode == 0, ran.stderr


def test_switching_on_does_not_load_the_compiled_core() -> None:
    script = "import sys, bpy, penumbra; penumbra.register(); assert 'penumbra_core' not in sys.modules"
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stderr


def test_progress_rises_to_the_end_and_the_last_line_says_what_was_done(
    addon: Kit, monkeypatch: pytest.MonkeyPatch
) -> None:
    from penumbra import engine

    edge_scene(addon)
    addon.scene.penumbra.pixel_samples = 3
    addon.scene.view_layers[0].penumbra.visibility = {"pcf"}
    told: list[tuple[float, str]] = []
    real = engine.PENUMBRA_RE_engine._tell

    def tell(self: Any, share: float, text: str) -> None:
        told.append((share, text))
        real(self, share, text)

    lines: list[str] = []
    line_of = engine._statistics

    def statistics(*given: Any) -> str:
        lines.append(line_of(*given))
        return lines[-1]

    monkeypatch.setattr(engine.PENUMBRA_RE_engine, "_tell", tell)
    monkeypatch.setattr(engine, "_statistics", statistics)
    assert bpy.ops.render.render() == {"FINISHED"}
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and shares[0] < 0.2 and 0.8 < shares[-1] <= 1
    assert {"what the camera sees", "Light: shadow_map", "Light: pcf"} <= {text for _, text in told}
    (line,) = lines
    *facts, seconds = line.split(" | ")
    assert facts == ["shadow_map, 1 light", "4 triangles", "3 pixel samples"]
    assert seconds.endswith(" s")


def test_where_the_technique_leaves_its_field_of_use_is_reported_and_counted(
    addon: Kit, monkeypatch: pytest.MonkeyPatch
) -> None:
    from penumbra import engine

    edge_scene(addon)
    bpy.data.lights["Light"].shadow_soft_size = 0.25
    addon.scene.penumbra.pixel_samples = 2
    said: list[str] = []
    monkeypatch.setattr(engine.PENUMBRA_RE_engine, "_warn", lambda self, note: said.append(note))
    lines: list[str] = []
    line_of = engine._statistics
    monkeypatch.setattr(engine, "_statistics", lambda *given: lines.append(line_of(*given)) or lines[-1])
    assert bpy.ops.render.render() == {"FINISHED"}
    (text,) = said
    assert text.startswith('"Light" is outside the field of use of shadow_map: the light is 0.5 m wide and one point')
    addon.scene.penumbra.technique = "light_samples"
    assert bpy.ops.render.render() == {"FINISHED"}
    assert len(said) == 1, "averaged maps are made for such a light"
    assert [line.endswith("| 1 warning") for line in lines] == [True, False]


def test_an_animation_changes_the_camera_at_each_marker(addon: Kit, tmp_path: Path) -> None:
    edge_scene(addon)
    scene = addon.scene
    first = scene.camera
    for frame, x in ((1, None), (2, 3.0), (3, -3.0)):
        marker = scene.timeline_markers.new(f"cut {frame}", frame=frame)
        look = {"type": "ORTHO", "ortho_scale": 2, "clip_start": 0.6, "clip_end": 10}
        marker.camera = first if x is None else addon.camera(f"Camera {frame}", at=(x, 0, 1.5), **look)
    scene.camera = first
    scene.frame_start, scene.frame_end = 1, 4
    lit = lit_shares(scene, tmp_path)
    assert 0.4 < lit[0] < 0.6, "half of it lies in the shadow"
    assert lit[1] == 0, "all of it"
    assert lit[2] == 1 and lit[3] == 1, "none of it; a marker serves until the next"
