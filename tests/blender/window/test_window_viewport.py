"""The extension in a Blender with a window: installed from its zip, drawing the viewport, gone when switched off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def answer(window: Callable[..., dict[str, Any]], packed: Path) -> dict[str, Any]:
    return window("viewport.py", "viewport", packed, ROOT / "examples" / "courtyard.blend")


def patch(answer: dict[str, Any], picture: str, side: str) -> np.ndarray:
    """Mean colour of 9 x 9 pixels of the screen, 0 .. 255."""
    x, y = answer[picture][side]
    pixels = np.asarray(Image.open(answer["folder"] / f"{picture}.png").convert("RGB"), float)
    return pixels[y - 4 : y + 5, x - 4 : x + 5].mean(axis=(0, 1))


def test_it_installs_and_enabling_it_loads_no_compiled_code(answer: dict[str, Any]) -> None:
    assert answer["enabled"]
    assert not answer["core_loaded_by_enabling"]


@pytest.mark.parametrize(
    ("picture", "lit", "dark"),
    [("top", "left", "right"), ("turned", "right", "left"), ("soft", "left", "right"), ("mended", "left", "right")],
)
def test_the_shadow_is_where_it_should_be(answer: dict[str, Any], picture: str, lit: str, dark: str) -> None:
    assert patch(answer, picture, lit).min() > 100
    assert patch(answer, picture, dark).max() < 6


def test_a_moved_object_s_shadow_moves(answer: dict[str, Any]) -> None:
    assert patch(answer, "moved", "left").min() > 100
    assert patch(answer, "moved", "right").min() > 100


def test_too_much_light_is_white_and_its_shadow_black(answer: dict[str, Any]) -> None:
    assert patch(answer, "dazzled", "left").min() > 250
    assert patch(answer, "dazzled", "right").max() < 6


def test_a_failure_is_words_over_the_last_picture(answer: dict[str, Any]) -> None:
    assert patch(answer, "broken", "left").min() > 100, "the last picture stays"
    good = np.asarray(Image.open(answer["folder"] / "dazzled.png").convert("RGB"), float)
    bad = np.asarray(Image.open(answer["folder"] / "broken.png").convert("RGB"), float)
    words = np.abs(bad - good).max(axis=2) > 60
    assert words.sum() > 300


def test_two_hundred_views_are_drawn_and_cost_no_memory(answer: dict[str, Any]) -> None:
    assert answer["pictures"] > 10
    memory = answer["resident_mb"]
    assert len(memory) == 10
    assert max(memory[5:]) - max(memory[:5]) < 50, memory


def test_a_camera_sees_the_courtyard(answer: dict[str, Any], guide: Callable[..., Image.Image]) -> None:
    left, top, width, height = answer["region"]
    seen = guide("viewport", (answer["folder"] / "camera.png", (left, top + height // 5, width, 3 * height // 4)))
    pixels = np.asarray(seen.convert("L"), float)
    assert pixels[:, width // 5 : -width // 5].std() > 25, "columns, floor and shadows"


def test_nothing_is_left_when_it_is_switched_off(answer: dict[str, Any]) -> None:
    assert answer["left_behind"] == []
