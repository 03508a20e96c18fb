"""A comparison runs while everything else happens in a Blender with a window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROUNDS, SCENES = 6, 3  # of comparison_stress.py: each scene comes twice


@pytest.fixture(scope="module")
def answer(window: Callable[..., dict[str, Any]], packed: Path) -> dict[str, Any]:
    return window("comparison_stress.py", "stress", packed)


@pytest.fixture(scope="module")
def control(window: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    """The same Blender doing the same without the add-on."""
    return window("comparison_stress.py", "control", words=["control"])


def test_two_hundred_views_changes_undo_engines_and_files_beside_a_comparison_end_well(answer: dict[str, Any]) -> None:
    assert answer["views"] >= 200
    assert answer["went_on"] == [True] * ROUNDS, "the comparison was running all the while"
    assert answer["rows"] == ["ok", "ok"], "and another one works after all that"


def test_opening_a_file_ends_the_comparisons_thread(answer: dict[str, Any]) -> None:
    assert answer["threads"] == [0] * (ROUNDS + 1)


def test_nothing_of_opengl_goes_wrong_in_blender_s_console(answer: dict[str, Any]) -> None:
    console = (answer["folder"] / "console.txt").read_text()
    assert not [line for line in console.splitlines() if "GL" in line and "rror" in line]
    assert "Traceback" not in console


def test_memory_does_not_grow_once_every_scene_and_engine_was_there(
    answer: dict[str, Any], control: dict[str, Any]
) -> None:
    """Of the growth from a scene's first round to its second, what Blender without the add-on does not have too."""

    def growth(run: dict[str, Any]) -> float:
        first, second = run["resident_mb"][:SCENES], run["resident_mb"][SCENES:]
        return max(second) - max(first)

    assert growth(answer) - max(growth(control), 0.0) < 50, (answer["resident_mb"], control["resident_mb"])
