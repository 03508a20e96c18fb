"""The whole extension, as users get it: installed from its zip without network, used, switched off, reloaded."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image


@pytest.fixture(scope="module")
def answer(window: Callable[..., dict[str, Any]], whole: Path) -> dict[str, Any]:
    return window("extension.py", "extension", whole)


def test_the_zip_holds_the_core_and_the_report_s_libraries_for_both_pythons(
    window: Callable[..., dict[str, Any]], whole: Path
) -> None:
    with zipfile.ZipFile(whole) as file:
        wheels = [Path(name).name for name in file.namelist() if name.endswith(".whl")]
        assert file.testzip() is None
    for tag in ("cp311", "cp313"):
        for library in ("penumbra_core", "matplotlib", "pillow", "flip_evaluator"):
            assert any(wheel.startswith(f"{library}-") and f"-{tag}-" in wheel for wheel in wheels), (library, tag)
    assert any(wheel.startswith("jinja2-") for wheel in wheels)
    assert not any(wheel.startswith("numpy-") for wheel in wheels), "Blender brings its own"


@pytest.mark.parametrize(
    ("step", "says"),
    [("install", 'Installed "penumbra"'), ("doctor", "Ready."), ("render", "render.png"), ("compare", "report: ")],
)
def test_it_installs_renders_and_compares_without_network(answer: dict[str, Any], step: str, says: str) -> None:
    code, words = answer[step]
    assert code == 0, words
    assert says in words
    assert "Traceback" not in words


def test_what_it_rendered_and_compared_is_there(answer: dict[str, Any]) -> None:
    assert np.asarray(Image.open(answer["folder"] / "render.png").convert("L"), float).std() > 25
    assert (answer["folder"] / "compare" / "report.html").read_text().rstrip().endswith("</html>")
    assert np.asarray(Image.open(answer["folder"] / "window.png").convert("L"), float).std() > 25


def test_switching_it_on_is_seen_everywhere(answer: dict[str, Any]) -> None:
    for on in answer["on"]:
        assert on["engines"] == ["PENUMBRA"] and "PENUMBRA_PT_comparison" in on["types"]
        assert {"Scene.penumbra", "Scene.penumbra_comparison"} <= set(on["properties"])
        assert on["keys"] == ["penumbra.overlay"]
        assert on["threads"] == []


def test_switching_it_off_at_work_leaves_nothing_five_times_over(answer: dict[str, Any]) -> None:
    assert not any(answer["before"].values())
    assert answer["off"] == [answer["before"]] * 5


def test_switching_it_on_and_off_takes_no_memory_threads_or_files(answer: dict[str, Any]) -> None:
    # The first rounds load libraries, whose pools of threads stay.
    for kept in ("system_threads", "files"):
        assert answer[kept][-1] <= max(answer[kept][:2]), (kept, answer[kept])
    assert answer["resident_mb"][-1] - max(answer["resident_mb"][:2]) < 50, answer["resident_mb"]


def test_reloading_scripts_leaves_it_as_it_was(answer: dict[str, Any]) -> None:
    assert answer["reloaded"] == answer["on"][0]
