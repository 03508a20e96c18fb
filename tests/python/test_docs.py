"""The documents: the site builds without a warning, and every technique has its page, its figures and its place."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import penumbra_core as core
import pytest

ROOT = Path(__file__).resolve().parents[2]
TECHNIQUES = [str(info["id"]) for info in core.techniques()]


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    loader = importlib.machinery.SourceFileLoader("gallery", str(ROOT / "tools" / "gallery"))
    spec = importlib.util.spec_from_loader("gallery", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["gallery"] = module
    loader.exec_module(module)
    return module


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("sphinx", reason="the extra 'docs' is not installed")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-q",
        "-W",
        "--keep-going",
        "-b",
        "html",
        str(ROOT / "docs"),
        str(tmp_path),
    ]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "Chan2004" in (tmp_path / "references.html").read_text()


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_every_technique_has_a_page_with_pictures_figures_and_a_place_in_the_site(technique: str) -> None:
    page = (ROOT / "docs" / "techniques" / f"{technique}.md").read_text()
    assert f"(`{technique}`)" in page.splitlines()[0]
    assert "images/gallery/" in page and "## On the examples" in page
    assert f"techniques/{technique}\n" in (ROOT / "docs" / "index.md").read_text()
    assert f"techniques/{technique}.md" in (ROOT / "README.md").read_text()


def test_the_gallery_is_whole(gallery: ModuleType) -> None:
    assert gallery.missing() == []
    page = (ROOT / "docs" / "gallery.md").read_text()
    for scene in gallery.EXAMPLES:
        shown = re.findall(rf"images/gallery/{scene}-(\w+)\.jpg", page)
        assert shown == TECHNIQUES, scene


def report_of(times: dict[str, float]) -> dict[str, Any]:
    def record(technique: str, time: float) -> dict[str, Any]:
        area = {"penumbra_rmse": 0.25, "bias": -0.01, "leak": 0.0, "penumbra_pixels": 10}
        times_ms = {kind: {"median": time} for kind in ("dynamic", "static")}
        return {
            "technique": technique, "status": "ok", "sweep": None, "error": {"area": area}, "time_ms": times_ms,
            "on_pareto_front": technique == "pcf",
        }  # fmt: skip

    records = [record(technique, time) for technique, time in times.items()]
    where = {"cpu": "A processor", "cores": 2, "gl_renderer": "A renderer", "embree": "3"}
    light = {"name": "Key", "shape": "rectangle", "records": [*records, {"technique": "plateaus", "status": "failed"}]}
    return {"environment": where, "scenes": [{"path": "examples/desk.blend", "lights": [light]}]}


def test_frames_are_told_over_the_hard_maps_of_the_same_light(gallery: ModuleType) -> None:
    report = report_of({"shadow_map": 4.0, "pcf": 10.0})
    made = gallery.figures(report)
    assert [figure.technique for figure in made] == ["shadow_map", "pcf"]
    section = gallery.page_section("pcf", made, report)
    assert "| desk | Key (rectangle) | 0.250 | -0.010 | 0.000 | 2.50 | 2.50 | yes |" in section
    assert "A processor, 2 cores, A renderer" in section


def test_a_section_of_figures_replaces_the_one_before_and_nothing_else(gallery: ModuleType) -> None:
    report = report_of({"shadow_map": 4.0, "pcf": 10.0})
    first = gallery.page_section("pcf", gallery.figures(report), report)
    slower = report_of({"shadow_map": 4.0, "pcf": 12.0})
    second = gallery.page_section("pcf", gallery.figures(slower), slower)
    page = gallery.with_section("# Filtering\n\nWords.\n", first)
    assert page.startswith("# Filtering\n\nWords.\n")
    again = gallery.with_section(page + "\nMore words.\n", second)
    assert "2.50" not in again and "3.00" in again and again.endswith("\nMore words.\n")
