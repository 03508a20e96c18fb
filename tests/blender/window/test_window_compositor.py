"""The compositor's group in a Blender with a window: one click, and the line parts two techniques."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
from PIL import Image


def test_one_click_wires_the_wipe_and_its_line_parts_two_techniques(
    window: Callable[..., dict[str, Any]], packed: Path, guide: Callable[..., Image.Image]
) -> None:
    answer = window("compositor.py", "compositor", packed)
    assert answer["added"] == ["FINISHED"]

    def still(name: str) -> np.ndarray:
        return np.asarray(OpenEXR.File(str(answer["folder"] / f"{name}.exr")).channels()["RGB"].pixels)

    a, b, wipe = still("a"), still("b"), still("wipe")
    left, top, width, height = answer["editor"]
    guide("compositor", (answer["folder"] / "nodes.png", (left, top, width, 2 * height // 3)))
    half = wipe.shape[1] // 2
    assert np.array_equal(wipe[:, 1 : half - 1], a[:, 1 : half - 1])
    assert np.array_equal(wipe[:, half + 1 : -1], b[:, half + 1 : -1])
    assert np.abs(a - b).max() > 0.5, "a hard shadow beside a soft one"
