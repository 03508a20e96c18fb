"""What the Python tests share. Without an installed package they run from the checkout."""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from must_run import skip

ROOT = Path(__file__).resolve().parents[2]
if importlib.util.find_spec("penumbra") is None:
    sys.path.insert(0, str(ROOT / "addon"))


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test reads or writes the user's references."""
    monkeypatch.setenv("PENUMBRA_CACHE", str(tmp_path_factory.mktemp("references")))
    monkeypatch.delenv("PENUMBRA_CACHE_SIZE", raising=False)
    monkeypatch.delenv("PENUMBRA_TRACEBACK", raising=False)


@pytest.fixture(scope="session")
def environment() -> dict[str, str]:
    """For subprocesses: they find the packages that this process found at its start.

    Not all of sys.path: Blender, imported by another test of this process, adds folders to it, and the package `bpy` in
    one of them would hide the module.
    """
    own = [path for path in sys.path if path == str(ROOT / "addon")]
    given = [path for path in (os.environ.get("PYTHONPATH"),) if path]
    return os.environ | {"PYTHONPATH": os.pathsep.join(own + given)}


Result = subprocess.CompletedProcess[str]


@pytest.fixture
def penumbra(environment: dict[str, str], tmp_path: Path) -> Callable[..., Result]:
    """Runs the command line in a process of its own, in an empty folder."""

    def run(*arguments: object, cwd: Path | None = None, **more: str) -> Result:
        return subprocess.run(
            [sys.executable, "-m", "penumbra", *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=600,
            cwd=cwd or tmp_path,
            env=environment | {"PENUMBRA_CACHE": os.environ["PENUMBRA_CACHE"]} | more,
        )

    return run


@pytest.fixture(scope="session")
def core() -> object:
    try:
        return importlib.import_module("penumbra_core")
    except ImportError as error:
        skip(f"the compiled core cannot be loaded: {error}")


@pytest.fixture(scope="session")
def working_machine(core: object, environment: dict[str, str]) -> None:
    """Skips where `penumbra doctor` says that comparing cannot work."""
    told = subprocess.run(
        [sys.executable, "-m", "penumbra", "doctor", "--json"], capture_output=True, text=True, env=environment
    )
    if told.returncode:
        broken = [check for check in json.loads(told.stdout)["checks"] if check["needed"] and not check["works"]]
        skip("; ".join(f"{check['name']}: {check['found']}" for check in broken))


_SCENE = """
import bpy, math, sys
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
def put(name, data):
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item
def mesh(name, corners, faces):
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    return put(name, data)
mesh("Floor", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)])
wall = [(-1, -0.05, 0), (1, -0.05, 0), (1, 0.05, 0), (-1, 0.05, 0)]
wall += [(x, y, 1) for x, y, _ in wall]
mesh("Wall", wall, [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
area = bpy.data.lights.new("Key", "AREA")
area.shape, area.size, area.energy = "SQUARE", 1.0, 300
put("Key", area).location = (0.3, 2, 3)
bpy.data.objects["Key"].rotation_euler = (-math.atan2(2, 3), 0, 0)
sun = bpy.data.lights.new("Sun", "SUN")
sun.angle, sun.energy = 0.05, 1.0
put("Sun", sun).rotation_euler = (0.5, 0.4, 0)
camera = bpy.data.cameras.new("Camera")
eye = put("Camera", camera)
eye.location, eye.rotation_euler = (0, -5, 4.5), (math.radians(48), 0, 0)
scene.camera = eye
scene.render.resolution_x, scene.render.resolution_y = 160, 96
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""


@pytest.fixture(scope="session")
def wall_blend(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wall on a floor under a square light and a sun, 160 x 96."""
    if importlib.util.find_spec("bpy") is None:
        skip("Blender's Python module is not installed")
    path = tmp_path_factory.mktemp("scenes") / "wall.blend"
    made = subprocess.run([sys.executable, "-c", _SCENE, str(path)], capture_output=True, text=True)
    assert path.is_file(), made.stderr
    return path


_ANIMATION = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[-2])
wall = bpy.data.objects["Wall"]
for frame, x in ((1, 0.0), (4, 1.5)):
    wall.location.x = x
    wall.keyframe_insert("location", frame=frame)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""


@pytest.fixture(scope="session")
def moving(wall_blend: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wall moves to the right from frame 1 to 4."""
    path = tmp_path_factory.mktemp("moving") / "moving.blend"
    program = [sys.executable, "-c", _ANIMATION, str(wall_blend), str(path)]
    made = subprocess.run(program, capture_output=True, text=True)
    assert path.is_file(), made.stderr
    return path


@pytest.fixture
def started(environment: dict[str, str], tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts `penumbra` and does not wait for it."""
    processes = []

    def start(words: list[str], **more: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, "-m", "penumbra", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            cwd=tmp_path, env=environment | {"PENUMBRA_CACHE": os.environ["PENUMBRA_CACHE"]} | more,
        )  # fmt: skip
        processes.append(process)
        return process

    yield start
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture(scope="session")
def chromium() -> str:
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("no chromium to open the page with")  # a large package for one test: never a must
    return found
