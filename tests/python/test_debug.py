"""`penumbra debug`: pictures of a technique's inside."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from penumbra import cli
from PIL import Image as Pillow

COURTYARD = Path(__file__).resolve().parents[2] / "examples" / "courtyard.blend"


def test_the_depth_map_shows_casters_nearer_than_the_floor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["debug", COURTYARD, "--technique", "shadow_map", "--set", "map_size=256", "--size", "160x90"]
    assert cli.main([*map(str, arguments), "--out", str(tmp_path)]) == 0
    (picture,) = tmp_path.glob("*.png")
    line = capsys.readouterr().out.splitlines()[0]
    assert line.startswith(str(picture))
    assert "Depth map" in line
    grey = np.asarray(Pillow.open(picture).convert("L"))
    assert grey.shape[0] == 256 and grey.shape[1] % 256 == 0, "one square per face"
    assert len(np.unique(grey)) > 20, "surfaces at many depths"


def test_an_unknown_view_is_refused_with_those_there_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["debug", COURTYARD, "--technique", "shadow_map", "--views", "cones", "--size", "16x9"]
    assert cli.main([*map(str, arguments), "--out", str(tmp_path / "new")]) == 2
    assert 'shadow_map has no view "cones" for this light; choose from: depth_map' in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_a_technique_without_an_inside_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["debug", COURTYARD, "--technique", "ray_traced", "--size", "16x9", "--out", tmp_path]
    assert cli.main([*map(str, arguments)]) == 2
    assert "ray_traced has no inside to show here" in capsys.readouterr().err
