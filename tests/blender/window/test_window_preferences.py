"""The extension's preferences in a Blender with a window: what works here, and the button that copies it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image


def test_the_preferences_tell_what_works_and_copy_it(
    window: Callable[..., dict[str, Any]], whole: Path, guide: Callable[..., Image.Image]
) -> None:
    answer = window("preferences.py", "preferences", whole)
    assert answer["examined"] == answer["copied"] == ["FINISHED"]
    lines = answer["clipboard"].splitlines()
    assert lines[-1] == "Ready."
    for what in ("core: penumbra_core", "OpenGL: llvmpipe", "Embree: ", "Blender: 4.3", "report: all libraries"):
        assert any(what in line for line in lines), (what, lines)
    shown = np.asarray(guide("preferences", (answer["folder"] / "preferences.png", answer["area"])), float)
    left, top, width, height = answer["area"]
    before = np.asarray(Image.open(answer["folder"] / "before.png").convert("RGB"), float)
    differs = np.abs(shown - before[top : top + height, left : left + width]).max(axis=2) > 30
    assert differs.mean() > 0.01, "what was found stands there"
