"""A comparison runs while everything else happens in a Blender with a window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def answer(window: Callable[..., dict[str, Any]], packed: Path) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as slow:
        slow.setenv("PENUMBRA_WINDOW_TIMEOUT", "560")
        return window("comparison_stress.py", "stress", packed)


def test_two_hundred_views_changes_undo_engines_and_files_beside_a_comparison_end_well(answer: dict[str, Any]) -> None:
    assert answer["views"] == 200
    assert answer["went_on"] == [True] * 4, "the comparison was running all the while"
    assert answer["rows"] == ["ok", "ok"], "and another one works after all that"


def test_opening_a_file_ends_the_comparisons_thread(answer: dict[str, Any]) -> None:
    assert answer["threads"] == [0] * 5


def test_memory_does_not_grow_once_every_scene_and_engine_was_there(answer: dict[str, Any]) -> None:
    # The second round takes much more than the first, with and without a comparison: the second scene, in Cycles too.
    *before, last = answer["resident_mb"]
    assert last - max(before) < 50, answer["resident_mb"]
