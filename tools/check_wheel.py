"""Proves a repaired wheel: what is in it, what it links, and that it works in a fresh virtual environment."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

# What the fresh environment must be able to do with the compiled module.
PROOF = """
import penumbra_core as core
from pathlib import Path
major = core.embree_version()
mapped = Path("/proc/self/maps").read_text().splitlines()
paths = {line.split()[-1] for line in mapped if "embree" in line or "libtbb" in line}
outside = [path for path in paths if not path.startswith(PREFIX)]
assert any("libembree" in path for path in paths), "no Embree was opened"
assert not outside, f"libraries from outside the wheel: {outside}"
print("penumbra_core", core.__version__, "with Embree", major)
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
            run(home / "venv" / "bin" / "penumbra", "techniques")


def main() -> int:
    wheel = Path(sys.argv[1]).resolve()
    check_contents(wheel)
    check_in_fresh_environment(wheel)
    print(f"{wheel.name}: {wheel.stat().st_size / 2**20:.1f} MiB, holds")
    return 0


if __name__ == "__main__":
    sys.exit(main())
