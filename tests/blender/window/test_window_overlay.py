"""The overlay in a Blender with a window: two halves, a wipe that a mouse drags, the truth, and nothing left behind."""

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
    return window("overlay.py", "overlay", packed, ROOT / "examples" / "courtyard.blend")


def region(answer: dict[str, Any], picture: str) -> np.ndarray:
    left, top, width, height = answer["region"]
    pixels = np.asarray(Image.open(answer["folder"] / f"{picture}.png").convert("RGB"), float)
    return pixels[top : top + height, left : left + width]


def wipe_line(pixels: np.ndarray) -> int:
    """Column of the white line, away from its grip and the words."""
    rows = pixels[pixels.shape[0] // 5 : pixels.shape[0] // 3]
    return int(np.argmax(rows.min(axis=(0, 2))))


def test_it_covers_the_viewport_and_goes_again(answer: dict[str, Any]) -> None:
    # The left half: the sidebar is open by the end.
    plain, on, off = (region(answer, name)[:, :500] for name in ("plain", "on", "off"))
    assert np.abs(on - plain).mean() > 10
    assert np.abs(off - plain).mean() < 0.5


def test_its_two_halves_are_two_techniques(answer: dict[str, Any]) -> None:
    """Left of the line hard shadows, right of it soft ones: dragging the line changes what lies between."""
    on, dragged = region(answer, "on"), region(answer, "dragged")
    width = on.shape[1]
    middle = np.s_[100:-100, width // 2 + 20 : 3 * width // 4 - 20]
    outside = np.s_[100:-100, : width // 2 - 20]
    assert np.abs(on[middle] - dragged[middle]).mean() > 0.5
    assert np.abs(on[outside] - dragged[outside]).mean() < 0.1


def test_a_mouse_drags_the_wipe_line(answer: dict[str, Any]) -> None:
    assert answer["wipe"] == pytest.approx(0.75, abs=0.01)
    width = answer["region"][2]
    assert wipe_line(region(answer, "on")) == pytest.approx(width / 2, abs=2)
    assert wipe_line(region(answer, "dragged")) == pytest.approx(0.75 * width, abs=3)


def test_the_error_is_in_false_colours_and_the_truth_beside_it(answer: dict[str, Any]) -> None:
    pixels = region(answer, "error")
    line = wipe_line(pixels)
    assert line == pytest.approx(0.45 * pixels.shape[1], abs=2)

    def colourful(part: np.ndarray) -> float:
        return float(((part[..., 0] > 100) & (part[..., 0] > 1.5 * part[..., 2])).mean())

    assert 0.002 < colourful(pixels[100:-100, : line - 8]) < 0.5
    # No error stands right of the line; what is brown there are fence and flower pots.
    assert (
        np.abs(pixels[100:-100, line + 8 : line + 200] - region(answer, "on")[100:-100, line + 8 : line + 200]).mean()
        < 8
    )


def test_the_guide_has_pictures_of_the_wipe_and_of_the_error(
    answer: dict[str, Any], guide: Callable[..., Image.Image]
) -> None:
    left, top, width, height = answer["region"]
    guide("overlay", (answer["folder"] / "on.png", (left, top + 40, width, height - 80)))
    picture = np.asarray(guide("error", (answer["folder"] / "error.png", (left, top, width, height))), float)
    # The legend stands clear of the sidebar, in all of its colours from black to bright.
    bar = picture[-48:-42, : answer["free"] - 24][:, -250:].mean(axis=0)
    assert bar[0].max() < 40 and bar[-1].min() > 140
    assert np.diff(bar.sum(axis=1)).min() > -12, "ever brighter"


def test_the_figures_under_the_cursor_are_those_of_the_pixel(answer: dict[str, Any]) -> None:
    figures = answer["figures"]
    _, _, width, height = answer["region"]
    assert answer["cursor"] == pytest.approx([0.356 * width, 0.449 * height], abs=1)
    assert 0.05 < figures["truth"] < 0.95, "amid a penumbra"
    assert figures["A - truth"] == pytest.approx(figures["A"] - figures["truth"])


def viewports(answer: dict[str, Any], picture: str) -> list[np.ndarray]:
    """The two viewports side by side, cut to one size, without headings and the gizmos above."""
    boxes = answer[picture]
    width, height = (min(box[edge] for box in boxes) for edge in (2, 3))
    pixels = np.asarray(Image.open(answer["folder"] / f"{picture}.png").convert("RGB"), float)
    return [pixels[top + 160 : top + height - 20, left : left + width] for left, top, _, _ in boxes]


def green(pixels: np.ndarray) -> float:
    """Share of the pixels that show the trees."""
    return float(((pixels[..., 1] > 1.15 * pixels[..., 0]) & (pixels[..., 1] > 1.15 * pixels[..., 2])).mean())


def test_a_viewport_in_local_view_shows_its_own_scene_and_the_others_show_all(answer: dict[str, Any]) -> None:
    one, other = viewports(answer, "both")
    assert green(one) > 0.002
    assert green(other) == pytest.approx(green(one), rel=0.1), "both show the whole scene"
    alone, beside = viewports(answer, "isolated")
    assert green(alone) == 0, "the trees are not in the local view"
    assert np.abs(alone - one).mean() > 4
    assert np.abs(beside - other).mean() < 0.5
    assert [len(names) for names in answer["both objects"]] == [27]
    few, all_of_them = sorted(answer["isolated objects"], key=len)
    assert few == ["Ground", "Plinth", "Suzanne"] and len(all_of_them) == 27


def test_what_moves_in_a_local_view_moves_in_all_viewports(answer: dict[str, Any]) -> None:
    for before, after in zip(viewports(answer, "isolated"), viewports(answer, "moved"), strict=True):
        assert np.abs(after - before).mean() > 1
    assert answer["moved objects"] == answer["isolated objects"]


def test_leaving_the_local_view_shows_all_again(answer: dict[str, Any]) -> None:
    for before, after in zip(viewports(answer, "both"), viewports(answer, "left"), strict=True):
        assert np.abs(after - before).mean() < 0.5
    assert answer["left objects"] == answer["both objects"]


def test_a_type_of_objects_that_a_viewport_hides_is_not_in_its_overlay(answer: dict[str, Any]) -> None:
    one, other = viewports(answer, "hidden")
    assert one.std() < 0.5 * other.std(), "an empty viewport beside a full one"
    assert [] in answer["hidden objects"]


def test_a_viewport_that_is_closed_costs_nothing_more(answer: dict[str, Any]) -> None:
    assert answer["regions after closing"] == 1


def test_switching_off_loading_and_disabling_leave_nothing(answer: dict[str, Any]) -> None:
    # That no thread stays the script waited for.
    assert not any("overlay" in module for module in answer["handlers"])
    assert answer["on_after_load"] is False
    assert answer["left_behind"] == []
