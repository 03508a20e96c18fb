"""Scene files: what opens, what is put round a bare mesh, and one sentence for everything else."""

from __future__ import annotations

import gzip
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blender_kit import Kit, bpy
from penumbra import scenes
from penumbra.scenes import SceneError

EXAMPLES = Path(__file__).parents[2] / "examples"


def write(path: Path, data: bytes | str) -> Path:
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def export_as(kit: Kit, folder: Path, suffix: str) -> Path:
    """The scene's one mesh in a file of another program."""
    path = folder / f"mesh{suffix}"
    with scenes.quiet():
        if suffix == ".obj":
            bpy.ops.wm.obj_export(filepath=str(path))
        elif suffix == ".ply":
            bpy.ops.wm.ply_export(filepath=str(path))
        elif suffix == ".stl":
            bpy.ops.wm.stl_export(filepath=str(path))
        elif suffix in {".glb", ".gltf"}:
            kind = "GLB" if suffix == ".glb" else "GLTF_SEPARATE"
            bpy.ops.export_scene.gltf(filepath=str(path), export_format=kind)
        else:
            bpy.ops.wm.usd_export(filepath=str(path))
    return path


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb", ".gltf", ".usda", ".usdc", ".usdz"])
def test_a_mesh_file_gets_a_floor_a_light_and_a_camera(kit: Kit, tmp_path: Path, suffix: str) -> None:
    kit.cube(half=2, at=(5, 1, 7))
    scene = scenes.open_scene(export_as(kit, tmp_path, suffix))
    assert {scenes.FLOOR, scenes.KEY_LIGHT, scenes.CAMERA} <= set(scene.objects.keys())
    export = scenes.read(size=(64, 36))
    assert (export.lights, export.camera, export.objects) == ([scenes.KEY_LIGHT], scenes.CAMERA, 2)
    assert export.notes[0] == "a mesh file; a floor, an area light and a camera were put round it"


def test_the_floor_lies_just_below_and_the_camera_sees_the_mesh(kit: Kit, tmp_path: Path) -> None:
    kit.cube(half=2, at=(5, 1, 7))
    scene = scenes.open_scene(export_as(kit, tmp_path, ".obj"))
    floor = scene.objects[scenes.FLOOR]
    assert 4.98 < floor.location.z < 5.0
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    for corner in ((3, -1, 5), (7, 3, 9), (3, 3, 9), (7, -1, 5)):
        seen = world_to_camera_view(scene, scene.camera, Vector(corner))
        assert 0 < seen.x < 1 and 0 < seen.y < 1
        assert scene.camera.data.clip_start < seen.z < scene.camera.data.clip_end


def test_lights_and_cameras_of_a_gltf_file_are_kept(kit: Kit, tmp_path: Path) -> None:
    kit.cube()
    kit.light("POINT", "Bulb", at=(0, 0, 5), energy=100)
    kit.camera("Shot", at=(0, 0, 10))
    path = tmp_path / "lit.glb"
    with scenes.quiet():
        bpy.ops.export_scene.gltf(filepath=str(path), export_lights=True, export_cameras=True)
    scenes.open_scene(path)
    export = scenes.read(size=(64, 36))
    assert export.notes[0] == "a mesh file; a floor was put under it"
    assert scenes.KEY_LIGHT not in export.lights
    assert export.camera != scenes.CAMERA


def test_a_blend_file_is_opened_and_scripts_in_it_do_not_run(kit: Kit, tmp_path: Path) -> None:
    kit.cube()
    text = bpy.data.texts.new("startup.py")
    text.write("import bpy; bpy.data.scenes[0].name = 'RAN'")
    text.use_module = True
    path = tmp_path / "scripted.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    scene = scenes.open_scene(path)
    assert scene.name == "Scene"
    assert "Cube" in scene.objects


def test_opening_a_file_forgets_the_one_before(kit: Kit, tmp_path: Path) -> None:
    kit.cube("Old")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "old.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    Kit().cube("New")
    path = export_as(Kit(), tmp_path, ".ply")
    scenes.open_scene(tmp_path / "old.blend")
    scene = scenes.open_scene(path)
    assert "Old" not in scene.objects


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("absent.blend", None, "does not exist"),
        ("notes.txt", "hello", 'ends in ".txt"; Penumbra opens .blend, .obj'),
        ("nothing", "hello", "has no ending; Penumbra opens .blend"),
        ("empty.blend", "", "is empty"),
        ("garbage.blend", "this is no blend file at all", "Blender cannot open"),
        ("cut.blend", b"BLENDER-v402" + b"DATA" * 40, "Blender cannot open"),
        ("future.blend", b"BLENDER17-01v0999" + b"REND" * 40, "was saved by Blender 9.99; this is Blender"),
        ("comment.obj", "# no mesh\n", "holds no mesh with faces"),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "holds no mesh with faces"),
        ("garbage.ply", "garbage", "Blender cannot import"),
        ("garbage.stl", "garbage", "Blender cannot import"),
        ("garbage.glb", "garbage", "Blender cannot import"),
        ("garbage.gltf", "{", "Blender cannot import"),
        ("garbage.usda", "garbage", "Blender cannot import"),
    ],
)
def test_what_cannot_be_opened_is_one_sentence(
    tmp_path: Path, name: str, content: bytes | str | None, sentence: str
) -> None:
    path = tmp_path / name
    if content is not None:
        write(path, content)
    with pytest.raises(SceneError) as caught:
        scenes.open_scene(path)
    text = str(caught.value)
    assert sentence in text
    assert str(path) in text
    assert "\n" not in text and not text.endswith(".")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    folder = tmp_path / "scene.blend"
    folder.mkdir()
    with pytest.raises(SceneError, match="is not a file"):
        scenes.open_scene(folder)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_says_so(tmp_path: Path) -> None:
    path = write(tmp_path / "secret.obj", "v 0 0 0")
    path.chmod(0)
    with pytest.raises(SceneError, match="may not be read"):
        scenes.open_scene(path)


def test_a_blend_file_without_a_mesh_is_one_sentence(kit: Kit, tmp_path: Path) -> None:
    kit.light("POINT")
    path = tmp_path / "lamp.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    with pytest.raises(SceneError, match="holds nothing to draw"):
        scenes.open_scene(path)


@pytest.mark.parametrize("compress", [False, True])
def test_the_version_in_a_header_is_read_compressed_or_not(kit: Kit, tmp_path: Path, compress: bool) -> None:
    path = tmp_path / "a.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress)
    version = scenes.blend_version(path)
    assert version == bpy.app.version[:2] or (compress and version is None)


def test_old_and_new_headers_are_understood(tmp_path: Path) -> None:
    assert scenes.blend_version(write(tmp_path / "a.blend", b"BLENDER_v248RENDH")) == (2, 48)
    assert scenes.blend_version(write(tmp_path / "b.blend", b"BLENDER17-01v0502REND")) == (5, 2)
    assert scenes.blend_version(write(tmp_path / "c.blend", gzip.compress(b"BLENDER-v279RENDH"))) == (2, 79)
    assert scenes.blend_version(write(tmp_path / "d.blend", b"nonsense")) is None


def test_nothing_is_printed_and_the_process_ends(tmp_path: Path) -> None:
    """A render engine left registered would hang Blender's module at exit."""
    program = (
        "from penumbra import scenes\n"
        f"scenes.open_scene({str(EXAMPLES / 'courtyard.blend')!r})\n"
        "assert scenes.read(size=(16, 9)).triangles > 10000\n"
    )
    # Blender in this process sets variables past Python, and tells of some that it finds.
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False, env=dict(os.environ)
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_without_blender_the_sentence_says_how_to_get_it(tmp_path: Path) -> None:
    program = (
        "import sys; sys.modules['bpy'] = None\n"
        "from penumbra import scenes\n"
        "try:\n    scenes.import_bpy()\nexcept scenes.SceneError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "Blender's Python module is not installed; run: pip install 'penumbra[bpy]'"


@pytest.mark.parametrize(
    ("name", "lights", "triangles"),
    [
        ("courtyard", {"Key": "rectangle"}, (15_000, 25_000)),
        ("desk", {"Window": "rectangle", "Lamp": "spot"}, (5_000, 20_000)),
        ("plaza", {"Sun": "sun", "Flood": "spot"}, (30_000, 60_000)),
    ],
)
def test_the_examples_are_what_they_say(name: str, lights: dict[str, str], triangles: tuple[int, int]) -> None:
    path = EXAMPLES / f"{name}.blend"
    assert path.stat().st_size < 1_000_000
    scenes.open_scene(path)
    export = scenes.read()
    assert {light.name: light.kind for light in export.scene.lights} == lights
    assert triangles[0] < export.triangles < triangles[1]
    assert export.size == (640, 360)
    # An older Blender opens them, and says so.
    assert [note for note in export.notes if not note.startswith("saved by Blender")] == []


def test_the_examples_are_made_the_same_again(tmp_path: Path) -> None:
    """Not byte by byte (Blender writes addresses and times), but triangle by triangle."""
    program = [sys.executable, str(EXAMPLES / "make_examples.py"), "--out", str(tmp_path)]
    subprocess.run(program, check=True, capture_output=True, timeout=120)

    def content(path: Path) -> Any:
        scenes.open_scene(path)
        scene = scenes.read().scene
        return scene.triangle_count, [light.power_w for light in scene.lights], np.array(scene.camera.world_from_camera)

    for name in ("courtyard", "desk", "plaza"):
        kept, made = content(EXAMPLES / f"{name}.blend"), content(tmp_path / f"{name}.blend")
        assert kept[:2] == made[:2]
        np.testing.assert_allclose(kept[2], made[2], atol=1e-6)
