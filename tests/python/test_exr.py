"""Our EXR files as OpenEXR's own library reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from penumbra import exr


def read(path: Path) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    file = OpenEXR.File(str(path), separate_channels=True)
    return file.header(), {name: channel.pixels for name, channel in file.channels().items()}


@pytest.mark.parametrize(("width", "height"), [(1, 1), (3, 16), (64, 17), (127, 33), (640, 360)])
def test_every_bit_comes_back(tmp_path: Path, width: int, height: int) -> None:
    generator = np.random.default_rng(width)
    channels = {
        "R": generator.integers(0, 2**32, (height, width), np.uint32).view(np.float32),  # incompressible; NaN too
        "visibility.Key": np.linspace(0, 1, height * width, dtype=np.float32).reshape(height, width),
        "A": np.zeros((height, width), np.float32),
        "edge": np.full((height, width), np.inf, np.float32),
    }
    (tmp_path / "a.exr").write_bytes(exr.encode(channels, {"made by": "Penumbra", "empty": ""}))
    header, found = read(tmp_path / "a.exr")
    assert set(found) == set(channels)
    for name, pixels in channels.items():
        assert found[name].dtype == np.float32
        assert np.array_equal(found[name].view(np.uint32), pixels.view(np.uint32)), name
    assert header["made by"] == "Penumbra"
    assert header["compression"] == OpenEXR.ZIP_COMPRESSION


def test_long_names_and_turned_arrays_come_back(tmp_path: Path) -> None:
    name = "visibility." + "Lumière_" * 20
    pixels = np.arange(12, dtype=np.float32).reshape(3, 4)
    (tmp_path / "a.exr").write_bytes(exr.encode({name: pixels[::-1], "x" * 31: pixels.T.copy().T}))
    _, found = read(tmp_path / "a.exr")
    assert np.array_equal(found[name], pixels[::-1])
    assert np.array_equal(found["x" * 31], pixels)


def test_smooth_pictures_shrink() -> None:
    ramp = np.tile(np.linspace(0, 1, 640, dtype=np.float32), (360, 1))
    assert len(exr.encode({"V": ramp})) < ramp.nbytes / 10
