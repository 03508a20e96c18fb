"""Blender 4.3 with a window (tools/blender_window). On demand only: PENUMBRA_WINDOW_TESTS=1, never in CI.

PENUMBRA_GUIDE=1 puts the pictures of docs/blender.md, which the tests make anyway, into docs/images.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[3]
TOOL = ROOT / "tools" / "blender_window"
KEPT = ROOT / "out" / "window"  # pictures and answers of the last run
# Blender 4.3 in Debian 13 takes the wheel that was built there.
WHEELHOUSES = (ROOT / "wheelhouse" / "trixie", ROOT / "wheelhouse")
TIMEOUT_S = "1500"  # of a script; on an idle machine the longest takes a tenth of this
LARGEST_PICTURE = 200_000  # bytes, in the guide

_MANIFEST = """schema_version = "1.0.0"
id = "penumbra_trap"
version = "1.0.0"
name = "Penumbra trap"
tagline = "Brings the compiled core, as the extension does"
maintainer = "Penumbra"
type = "add-on"
blender_version_min = "4.2.0"
license = ["SPDX:GPL-3.0-or-later"]
wheels = ["./wheels/{wheel}"]
"""


@pytest.fixture(scope="session")
def window() -> Callable[..., dict[str, Any]]:
    """Runs a script of this folder in Blender's window; returns its answer and keeps what it wrote in out/window."""
    if os.environ.get("PENUMBRA_WINDOW_TESTS") != "1" or os.environ.get("CI"):
        pytest.skip("tests in Blender's window run on demand: tools/blender_window test")
    told = subprocess.run([TOOL, "status"], capture_output=True, text=True)
    if told.returncode:
        pytest.skip(told.stdout.strip())

    def run(script: str, name: str, *files: Path, words: Sequence[str] = ()) -> dict[str, Any]:
        folder = KEPT / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for file in files:
            (folder / file.name).write_bytes(file.read_bytes())
        ran = subprocess.run(
            [TOOL, "run", Path(__file__).parent / script, folder, *(f"/out/{file.name}" for file in files), *words],
            capture_output=True,
            text=True,
            env={"PENUMBRA_WINDOW_TIMEOUT": TIMEOUT_S} | os.environ,
        )
        (folder / "console.txt").write_text(ran.stdout + ran.stderr)
        assert (folder / "answer.json").is_file(), ran.stdout + ran.stderr
        answer: dict[str, Any] = json.loads((folder / "answer.json").read_text())
        assert "error" not in answer, answer["error"]
        assert ran.returncode == 0, ran.stdout + ran.stderr
        assert not answer["background"]
        return answer | {"folder": folder}

    return run


@pytest.fixture
def extension(tmp_path: Path) -> Callable[[str], Path]:
    """An extension zip around the core wheel for Blender 4.3's Python, from a folder in the repository."""

    def make(wheelhouse: str) -> Path:
        wheels = sorted((ROOT / wheelhouse).glob("penumbra_core-*-cp313-*.whl"), key=lambda path: path.stat().st_mtime)
        if not wheels:
            pytest.skip(f"no core wheel for CPython 3.13 in {wheelhouse}; run: tools/blender_window test")
        path = tmp_path / "extension.zip"
        with zipfile.ZipFile(path, "w") as file:
            file.writestr("blender_manifest.toml", _MANIFEST.format(wheel=wheels[-1].name))
            file.writestr("__init__.py", "def register():\n    pass\n\n\ndef unregister():\n    pass\n")
            file.write(wheels[-1], f"wheels/{wheels[-1].name}")
        return path

    return make


def _pack(path: Path, *options: str) -> Path:
    subprocess.run([sys.executable, ROOT / "tools" / "build_extension", "--out", path, *options], check=True)
    return path


def _need_core(python: str) -> None:
    tag = f"cp{python.replace('.', '')}"
    if not any(list(folder.glob(f"penumbra_core-*-{tag}-*.whl")) for folder in WHEELHOUSES):
        pytest.skip(f"no core wheel for CPython {python}; run: tools/blender_window test")


@pytest.fixture(scope="session")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extension zip with the core's wheel for Blender 4.3's Python; without the report's libraries, for speed."""
    _need_core("3.13")
    return _pack(tmp_path_factory.mktemp("extension") / "penumbra.zip", "--python", "3.13", "--without-report")


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extension zip as users get it: wheels for both Pythons, the report's libraries among them."""
    _need_core("3.11")
    _need_core("3.13")
    return _pack(tmp_path_factory.mktemp("whole") / "penumbra.zip")


@pytest.fixture(scope="session")
def guide() -> Callable[..., Image.Image]:
    """Makes a picture of the user guide from parts of pictures of the screen, side by side; @returns it.

    A part is a picture with its box in it: left, top, width, height.
    """

    def make(name: str, *parts: tuple[Path, Sequence[int]]) -> Image.Image:
        cut = []
        for picture, (left, top, width, height) in parts:
            cut.append(Image.open(picture).convert("RGB").crop((left, top, left + width, top + height)))
        whole = Image.new("RGB", (sum(part.width for part in cut), max(part.height for part in cut)))
        for number, part in enumerate(cut):
            whole.paste(part, (sum(before.width for before in cut[:number]), 0))
        folder = ROOT / "docs" / "images" if os.environ.get("PENUMBRA_GUIDE") == "1" else KEPT / "guide"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"blender-{name}.png"
        shown = whole
        while True:
            # Coverage keeps the techniques' colours apart, few pixels as they have.
            few = shown.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            for made in (shown, few):
                made.save(path, optimize=True)
                if path.stat().st_size < LARGEST_PICTURE:
                    return whole
            shown = whole.resize((shown.width * 9 // 10, shown.height * 9 // 10), Image.Resampling.LANCZOS)

    return make
