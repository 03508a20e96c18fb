"""`penumbra bake`: shadows as textures, and where they lie."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from penumbra import cli
from PIL import Image as Pillow

COURTYARD = Path(__file__).resolve().parents[2] / "examples" / "courtyard.blend"


def test_every_plane_gets_an_image_and_a_quad(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["bake", COURTYARD, "--set", "size=128", "--size", "160x90", "--out", tmp_path]
    assert cli.main([*map(str, arguments)]) == 0
    assert str(tmp_path / "planes.json") in capsys.readouterr().out
    planes = json.loads((tmp_path / "planes.json").read_text())["planes"]
    assert planes
    obj = (tmp_path / "planes.obj").read_text().splitlines()
    assert sum(line.startswith("f ") for line in obj) == len(planes)
    assert sum(line.startswith("v ") for line in obj) == 4 * len(planes)
    assert [line for line in obj if line.startswith("vt ")] == ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    materials = (tmp_path / "planes.mtl").read_text()
    shades = set()
    for plane in planes:
        picture = np.asarray(Pillow.open(tmp_path / plane["image"]))
        assert list(picture.shape[::-1]) == plane["size"]
        assert f"map_Kd {plane['image']}" in materials
        shades |= set(np.unique(picture))
        a, b, c, d = np.asarray(plane["corners_m"])
        np.testing.assert_allclose(b - a, c - d, atol=1e-9)  # a rectangle, texels square
        assert abs(np.dot(b - a, d - a)) < 1e-6 * np.linalg.norm(b - a) * np.linalg.norm(d - a)
        aspect = np.linalg.norm(b - a) / np.linalg.norm(d - a)
        assert aspect == pytest.approx(plane["size"][0] / plane["size"][1], rel=1e-5)
    assert {0, 255} <= shades and len(shades) > 20, "umbra, light and the slopes between"


def test_a_technique_without_textures_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "new"
    arguments = ["bake", COURTYARD, "--technique", "shadow_map", "--size", "16x9", "--out", out]
    assert cli.main([*map(str, arguments)]) == 2
    assert "shadow_map makes no textures" in capsys.readouterr().err
    assert not out.exists()
