"""`blender -b shot.blend --command penumbra` in Blender's own program, from the extension zip as users install it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import OpenEXR
import pytest
from conftest import KEPT, ROOT, TOOL

Steps = dict[str, tuple[int, str]]

_SCENE = """
import bpy, math, sys
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
def put(name, data, **values):
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    for key, value in values.items():
        setattr(item, key, value)
    return item
def box(name, low, high):
    data = bpy.data.meshes.new(name)
    (x0, y0, z0), (x1, y1, z1) = low, high
    corners = [(x, y, z) for z in (z0, z1) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    data.from_pydata(corners, [], [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
    return put(name, data)
box("Floor", (-4, -4, -0.1), (4, 4, 0))
wall = box("Wall", (-1, -0.05, 0), (1, 0.05, 1))
for frame, x in ((1, 0.0), (4, 1.5)):
    wall.location.x = x
    wall.keyframe_insert("location", frame=frame)
area = bpy.data.lights.new("Key", "AREA")
area.shape, area.size, area.energy = "SQUARE", 1.0, 300
put("Key", area, location=(0.3, 2, 3), rotation_euler=(-math.atan2(2, 3), 0, 0))
camera = bpy.data.cameras.new("Camera")
scene.camera = put("Camera", camera, location=(0, -5, 4.5), rotation_euler=(math.radians(48), 0, 0))
scene.render.resolution_x, scene.render.resolution_y = 160, 96
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""


@pytest.fixture(scope="module")
def folder() -> Path:
    path = KEPT / "command"
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


@pytest.fixture(scope="module")
def steps(folder: Path) -> Steps:
    """Exit code and words of every step of command.sh."""
    if os.environ.get("PENUMBRA_WINDOW_TESTS") != "1" or os.environ.get("CI"):
        pytest.skip("tests in Blender's own program run on demand: tools/blender_window test")
    told = subprocess.run([TOOL, "status"], capture_output=True, text=True)
    if told.returncode:
        pytest.skip(told.stdout.strip())
    core = Path(os.environ.get("PENUMBRA_CORE_WHEELS", ROOT / "wheelhouse" / "trixie"))
    if not list(core.glob("penumbra_core-*-cp313-*.whl")):
        pytest.skip(f"no core wheel for CPython 3.13 in {core}; run: tools/blender_window test")
    packed = [ROOT / "tools" / "build_extension", "--core", core, "--python", "3.13", "--out", folder / "penumbra.zip"]
    subprocess.run([sys.executable, *packed], check=True)
    subprocess.run([sys.executable, "-c", _SCENE, folder / "wall.blend"], check=True, capture_output=True)
    script = f"/penumbra/{Path(__file__).with_name('command.sh').relative_to(ROOT)}"
    ran = subprocess.run(
        [TOOL, "shell", "bash", script, f"/penumbra/{folder.relative_to(ROOT)}"], capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    codes = folder.glob("*.code")
    return {path.stem: (int(path.read_text()), path.with_suffix(".txt").read_text()) for path in codes}


@pytest.mark.parametrize(
    ("step", "code", "says"),
    [
        ("install", 0, 'Installed "penumbra"'),
        ("version", 0, "penumbra 0."),
        ("wrong", 2, 'unknown technique "shadw"; did you mean shadow_map?'),
        ("compare", 0, "report: "),
        ("gate", 4, "above --fail-rmse 0.01"),
        ("render", 0, "picture.exr"),
        ("batch", 0, "3 items: 0 done before, 3 to do (3 new)"),
        ("again", 0, "3 items: all done before"),
        ("crash", 1, "wall/0001: its worker process died of SIGSEGV, twice"),
        ("interrupt", 130, "penumbra: interrupted"),
        ("disable", 0, ""),
    ],
)
def test_a_step_ends_with_its_code_and_its_words(steps: Steps, step: str, code: int, says: str) -> None:
    ended, words = steps[step]
    assert ended == code, words
    assert says in words
    assert "Traceback" not in words


def test_what_was_delivered_is_whole(steps: Steps, folder: Path) -> None:
    assert "report: " in steps["compare"][1]
    assert (folder / "compare" / "report.html").read_text().rstrip().endswith("</html>")
    picture = OpenEXR.File(str(folder / "picture.exr"), separate_channels=True)
    assert {"R", "G", "B", "visibility.Key"} <= set(picture.channels())
    shots = {shot["id"] for shot in json.loads((folder / "batch" / "summary.json").read_text())["shots"]}
    assert shots == {"wall/0001", "wall/0002", "wall/0003"}
    assert [path.name for path in (folder / "crash" / "wall").iterdir()] == ["0002"]
    environment = json.loads((folder / "batch" / "wall" / "0001" / "report.json").read_text())["environment"]
    assert environment["blender"].startswith("4.")


def test_an_interrupted_batch_keeps_what_is_finished_and_leaves_no_process(steps: Steps, folder: Path) -> None:
    assert steps["interrupt"][0] == 130
    assert (folder / "left.txt").read_text() == ""
    items = list((folder / "stopped" / "wall").iterdir())
    assert items and all((item / "report.html").is_file() and (item / "item.json").is_file() for item in items)
    assert not (folder / "stopped" / ".penumbra").exists()
