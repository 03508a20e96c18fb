"""Proves a repaired wheel: what is in it, what it links, and that it works in a fresh virtual environment."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

# What the fresh environment must be able to do with the compiled module: trace a square's shadow, with libraries from
# the wheel alone.
PROOF = """
from pathlib import Path

import numpy
import penumbra_core as core

corners = numpy.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
square = core.Mesh("square", corners, numpy.uint32([[0, 1, 2], [0, 2, 3]]))
blocker = numpy.diag([0.25, 0.25, 1.0, 1.0])
blocker[2, 3] = 0.5
scene = core.Scene()
scene.add_instance("floor", square, numpy.eye(4), numpy.float32([[0.8, 0.8, 0.8]]))
scene.add_instance("blocker", square, blocker, numpy.float32([[0.8, 0.8, 0.8]]), visible=False)
light = core.Light()
light.kind = "point"
light.position_ws = [0, 0, 1]
light.radius_m = 0.1
scene.add_light(light)
camera = core.Camera()
camera.world_from_camera = numpy.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]])
camera.width_px = camera.height_px = 64
scene.camera = camera
renderer = core.Renderer()
renderer.set_scene(scene)
v = renderer.visibility(0, "ray_traced", {"rays": 16})["visibility"]
assert v[32, 32] == 0.0, f"under the blocker V is {v[32, 32]}"
assert v[1, 1] == 1.0, f"in the corner V is {v[1, 1]}"

mapped = Path("/proc/self/maps").read_text().splitlines()
paths = {line.split()[-1] for line in mapped if "embree" in line or "libtbb" in line}
outside = [path for path in paths if not path.startswith(PREFIX)]
assert any("libembree" in path for path in paths), "no Embree was opened"
assert not outside, f"libraries from outside the wheel: {outside}"
print("penumbra_core", core.__version__, "traces with Embree", core.embree_version())
"""


def check_contents(wheel: Path) -> None:
    """The compiled package with its companions, and at most one copy of the add-on's code."""
    names = zipfile.ZipFile(wheel).namelist()
    core_only = wheel.name.startswith("penumbra_core-")
    for wanted in ("penumbra_core/__init__.py", "penumbra_core/_core.pyi", "penumbra_core/py.typed"):
        assert wanted in names, f"{wheel.name} lacks {wanted}"
    assert any(name.startswith("penumbra_core/_core.") and name.endswith(".so") for name in names), "no compiled module"
    assert "penumbra_core/penumbra_embree.so" in names, "no Embree plugin"
    assert any(".libs/libembree" in name for name in names), "Embree was not put inside"
    has_addon = any(name.startswith("penumbra/") for name in names)
    assert has_addon != core_only, f"{wheel.name}: the add-on's code is {'in' if has_addon else 'not in'} it"
    stray = [name for name in names if name.endswith((".a", ".h", ".cmake"))]
    assert not stray, f"build files in the wheel: {stray}"


def check_in_fresh_environment(wheel: Path) -> None:
    """Installs the wheel with its dependencies and runs it where neither the repository nor -dev packages help."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder).resolve()
        venv.create(home / "venv", with_pip=True)
        python = home / "venv" / "bin" / "python"
        environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV")}

        def run(*command: object) -> None:
            subprocess.run([str(part) for part in command], check=True, cwd=home, env=environment)

        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel)
        run(python, "-c", f"PREFIX = {str(home)!r}\n{PROOF}")
        if not wheel.name.startswith("penumbra_core-"):
            run(home / "venv" / "bin" / "penumbra", "--help")


def main() -> int:
    wheel = Path(sys.argv[1]).resolve()
    check_contents(wheel)
    check_in_fresh_environment(wheel)
    print(f"{wheel.name}: {wheel.stat().st_size / 2**20:.1f} MiB, holds")
    return 0


if __name__ == "__main__":
    sys.exit(main())
