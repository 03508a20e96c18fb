"""On machines that lack a graphics driver, a screen or a library every part says so in one sentence, and none crashes.

Each in a process of its own, since a driver is looked for once.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import penumbra
import pytest

NO_DEVICE = (
    "no OpenGL device: libEGL lists none; install a driver (Debian, Ubuntu: apt install libegl1 libgl1-mesa-dri)"
)

_ALL_PARTS = """
import json, time
import bpy
import penumbra

penumbra.register()
from penumbra import bridge, picture, preferences, session
from penumbra.comparison import running
from penumbra.viewport.pictures import Pictures
from penumbra.viewport.worker import Worker

scene = bpy.context.scene
scene.render.engine = "PENUMBRA"
scene.render.resolution_percentage = 2
scene.penumbra.pixel_samples = 1
scene.penumbra_comparison.view = "CAMERA"

def said(action):
    try:
        return sorted(action())
    except Exception as error:
        return str(error)

told = {
    "render": said(lambda: bpy.ops.render.render()),
    "animation": said(lambda: bpy.ops.render.render(animation=True)),
    "compare": said(lambda: bpy.ops.penumbra.compare()),
    "panel": running.problem(),
    "examine": said(lambda: bpy.ops.penumbra.examine()),
    "examination": preferences.PENUMBRA_OT_examine.text,
}
# What the viewport writes over itself.
export = bridge.read_scene(bpy.context.evaluated_depsgraph_get())
worker = Worker()
wanted = picture.Wanted(technique="shadow_map", settings={})
worker.ask(Pictures().question("a", export, lambda size: export.scene.camera, (8, 8), wanted, smaller=1))
end = time.monotonic() + 60
while not worker.problem and worker.shown is None and time.monotonic() < end:
    time.sleep(0.01)
told["viewport"] = worker.problem or ("a picture" if worker.shown else "nothing")
worker.close()
told["renderers"] = session.count()
penumbra.unregister()
print("TOLD " + json.dumps(told), flush=True)
"""


def blender(script: str, environment: dict[str, str]) -> dict[str, Any]:
    """What a process with Blender as a module tells; it must end by itself, and well."""
    folders = [str(Path(penumbra.__file__).parents[1]), *filter(None, [environment.get("PYTHONPATH")])]
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120,
        env=environment | {"PYTHONPATH": os.pathsep.join(folders)},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert "Traceback" not in ran.stderr + ran.stdout, ran.stderr + ran.stdout
    (line,) = [line for line in ran.stdout.splitlines() if line.startswith("TOLD ")]
    told: dict[str, Any] = json.loads(line.removeprefix("TOLD "))
    return told


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """An environment whose EGL knows no driver."""
    nothing = tmp_path / "no driver.json"
    nothing.touch()
    return os.environ | {"__EGL_VENDOR_LIBRARY_FILENAMES": str(nothing), "PENUMBRA_CACHE": str(tmp_path / "cache")}


def test_without_a_graphics_driver_engine_panel_viewport_and_doctor_say_so_and_blender_goes_on(
    bare: dict[str, str],
) -> None:
    told = blender(_ALL_PARTS, bare)
    for part in ("render", "animation", "compare", "panel", "viewport"):
        assert NO_DEVICE in told[part], part
        assert "\n" not in told[part].strip(), f"{part}: one sentence"
    assert told["examine"] == ["FINISHED"]
    assert f"MISSING EGL devices: {NO_DEVICE}" in told["examination"]
    assert "Not ready" in told["examination"]
    assert told["renderers"] == [0, 0]


def test_without_a_graphics_driver_the_command_line_refuses_and_writes_nothing(
    bare: dict[str, str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    courtyard = Path(__file__).resolve().parents[2] / "examples" / "courtyard.blend"
    folders = [str(Path(penumbra.__file__).parents[1]), *filter(None, [bare.get("PYTHONPATH")])]
    for words in (
        ["compare", str(courtyard), "--out", str(out)],
        ["render", str(courtyard), "--technique", "shadow_map", "--out", str(out / "a.png")],
    ):
        ran = subprocess.run(
            [sys.executable, "-m", "penumbra", *words], capture_output=True, text=True, timeout=120,
            env=bare | {"PYTHONPATH": os.pathsep.join(folders)},
        )  # fmt: skip
        assert ran.returncode == 2, words
        assert ran.stderr.strip() == f"penumbra: {NO_DEVICE}"
        assert not out.exists()


def test_without_a_screen_everything_works(tmp_path: Path) -> None:
    """No X server, no Wayland, no session: as on a farm."""
    names = ("DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR", "XAUTHORITY", "DBUS_SESSION_BUS_ADDRESS")
    environment = {key: value for key, value in os.environ.items() if key not in names}
    told = blender(_ALL_PARTS, environment | {"PENUMBRA_CACHE": str(tmp_path / "cache")})
    assert told["render"] == told["compare"] == ["FINISHED"]
    assert told["viewport"] == "a picture"
    assert "Ready." in told["examination"]


def test_without_the_compiled_core_the_add_on_is_there_and_names_the_loaders_reason(tmp_path: Path) -> None:
    """As where the extension holds no wheel for this Blender's Python."""
    (tmp_path / "penumbra_core").mkdir()
    (tmp_path / "penumbra_core" / "__init__.py").write_text("raise ImportError('libfoo.so.7: cannot open')")
    script = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n" + _ALL_PARTS.replace(
        "export = bridge.read_scene(bpy.context.evaluated_depsgraph_get())", "export = None"
    ).replace("lambda size: export.scene.camera", "None")
    told = blender(script, dict(os.environ))
    version = ".".join(map(str, sys.version_info[:2]))
    for part in ("render", "compare", "panel", "viewport"):
        assert f"penumbra_core cannot be loaded in Python {version} (libfoo.so.7: cannot open)" in told[part], part
    assert "MISSING core" in told["examination"]
