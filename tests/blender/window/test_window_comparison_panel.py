"""The comparison panel in a Blender with a window: it works beside the artist, fills its table, and shows a result."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image


@pytest.fixture(scope="module")
def answer(window: Callable[..., dict[str, Any]], whole: Path) -> dict[str, Any]:
    return window("comparison_panel.py", "comparison", whole)


def screen(answer: dict[str, Any], picture: str, box: str) -> np.ndarray:
    """(h, w, 3) of a part of the screen."""
    left, top, width, height = answer[box]
    pixels = np.asarray(Image.open(answer["folder"] / f"{picture}.png").convert("RGB"), int)
    return pixels[top : top + height, left : left + width]


def test_the_operator_returns_at_once_and_the_table_is_filled_later(answer: dict[str, Any]) -> None:
    assert not answer["core_loaded_by_enabling"], "switching on does not load the core"
    assert answer["started"] == ["FINISHED"]
    assert answer["progress"] is not None, "it runs while the artist works"
    assert answer["problem"] == ""
    assert len(answer["rows"]) == 7
    assert all(status == "ok" and 0 < error < 1 and time > 0 for _, status, error, time in answer["rows"])


def test_undoing_what_the_artist_did_keeps_the_results(answer: dict[str, Any]) -> None:
    assert answer["rows_after_undo"] == 7
    assert not answer["meanwhile_after_undo"], "that was what was undone"


def test_a_result_stands_in_the_image_editor(answer: dict[str, Any]) -> None:
    assert answer["shown"] == ["FINISHED"]
    assert answer["shown_image"] == "Penumbra Error"
    pixels = screen(answer, "shown", "image_editor")
    burning = (pixels[..., 0] > 200) & (pixels[..., 2] < 120)
    assert burning.mean() > 0.01, "false colours of the error"


def test_without_an_image_editor_a_result_gets_a_window_of_its_own(answer: dict[str, Any]) -> None:
    assert len(answer["windows"]) == 2
    assert "IMAGE_EDITOR" not in answer["windows"][0]
    assert answer["windows"][1] == ["IMAGE_EDITOR"]


def test_a_click_on_a_row_shows_it_where_a_result_stands_already(answer: dict[str, Any]) -> None:
    assert answer["rows"][answer["active_before"]][0] == "plateaus"
    assert answer["clicked"] == answer["followed"] == "Smoothies"


def test_the_view_of_the_viewport_is_compared_in_its_own_shape(answer: dict[str, Any]) -> None:
    width, height = answer["view_size"]
    assert answer["view_heading"] == f"3D viewport, {width} x {height}, frame 1"
    assert answer["view_rows"] == ["ok"] * 7


def test_blender_ends_by_itself_while_a_comparison_runs(answer: dict[str, Any]) -> None:
    assert answer["left_running"], "and the fixture saw it end with code 0"


def test_the_panel_draws_table_plot_and_thumbnails(answer: dict[str, Any], guide: Callable[..., Image.Image]) -> None:
    """The techniques' colours stand in the sidebar: dots of the table, marks of the plot, bars of the thumbnails."""
    from penumbra.report import palette

    seen = dict.fromkeys(range(7), 0)
    for number in range(1, 9):
        sidebar = screen(answer, f"scrolled_{number}", "sidebar")
        for colour in seen:
            code = np.array(list(bytes.fromhex(palette.colour(colour).lstrip("#"))))
            seen[colour] += int((np.abs(sidebar - code).max(axis=-1) < 12).sum())
    assert min(seen.values()) > 100, seen
    guide("panel", *((answer["folder"] / f"scrolled_{number}.png", answer["sidebar"]) for number in (2, 3, 5)))
    before, midway = (screen(answer, name, "sidebar_before") for name in ("before", "midway"))
    assert not np.array_equal(before, midway), "the progress bar"


def test_use_cheapest_sets_the_fastest_technique_within_the_error(answer: dict[str, Any]) -> None:
    assert answer["used"] == ["FINISHED"]
    within = [(time, technique) for technique, _, error, time in answer["rows"] if error <= answer["target"]]
    assert 0 < len(within) < 7
    assert answer["technique_used"] == min(within)[1]


def test_open_report_hands_a_whole_page_to_the_browser(answer: dict[str, Any]) -> None:
    assert answer["report"] == ["FINISHED"]
    opened = (answer["folder"] / "opened.txt").read_text().splitlines()
    assert opened == ["file:///out/courtyard/report.html"]
    page = (answer["folder"] / "courtyard" / "report.html").read_text()
    assert page.rstrip().endswith("</html>")
    assert all(name in page for name in ("Smoothies", "Plateaus"))
    assert list((answer["folder"] / "courtyard").rglob("*.exr"))
