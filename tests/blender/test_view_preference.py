"""The preference that says what finds the surface in each pixel, in a real Blender: it reaches who makes pictures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from blender_kit import Kit


@pytest.fixture
def own(addon: Kit, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The add-on's preferences, as new."""
    monkeypatch.delenv("PENUMBRA_VIEW_BY", raising=False)
    entry = bpy.context.preferences.addons.new()
    entry.module = "penumbra"
    yield entry.preferences
    bpy.context.preferences.addons.remove(entry)


@pytest.fixture
def scene(addon: Kit) -> Kit:
    addon.plate_over_floor()
    addon.scene.penumbra.pixel_samples = 1
    bpy.context.view_layer.update()
    return addon


def test_until_something_is_chosen_the_environment_decides(own: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from penumbra import native, preferences

    assert native.view_by(preferences.view_by()) == "raster"
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "rays")
    assert native.view_by(preferences.view_by()) == "rays"
    own.view_by = "raster"
    assert native.view_by(preferences.view_by()) == "raster", "what was chosen stays, also where it is the default"
    own.property_unset("view_by")
    assert native.view_by(preferences.view_by()) == "rays"


def test_the_examination_says_what_is_chosen(own: Any) -> None:
    from penumbra.preferences import PENUMBRA_OT_examine

    own.view_by = "rays"
    bpy.ops.penumbra.examine()
    assert "view: traced by Embree (rays)" in PENUMBRA_OT_examine.text


def rendered(path: Path) -> Any:
    bpy.context.scene.render.filepath = str(path)
    bpy.context.scene.render.image_settings.file_format = "PNG"
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    image = bpy.data.images.load(str(path))
    pixels = np.array(image.pixels[:], np.float32).reshape(64, 96, 4)
    bpy.data.images.remove(image)
    return pixels


def test_a_render_is_made_as_chosen_and_looks_the_same(own: Any, scene: Kit, tmp_path: Path) -> None:
    from penumbra import session

    session.release()
    drawn = rendered(tmp_path / "drawn.png")
    own.view_by = "rays"
    traced = rendered(tmp_path / "traced.png")
    assert {view: made.environment["view_by"] for (_, view), made in session._kept.items()} == {
        "raster": "raster",
        "rays": "rays",
    }
    assert drawn[..., :3].max() > 0
    assert np.count_nonzero(np.abs(drawn - traced).max(axis=2) > 0.02) <= 8


def test_a_wrong_word_in_the_environment_ends_a_render_as_a_sentence(
    own: Any, scene: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PENUMBRA_VIEW_BY", "ray")
    scene.scene.render.filepath = str(tmp_path / "a.png")
    with pytest.raises(RuntimeError, match='unknown PENUMBRA_VIEW_BY "ray"; did you mean rays'):
        bpy.ops.render.render(write_still=True)
    assert list(tmp_path.iterdir()) == []


def test_a_comparison_in_the_panel_is_made_as_chosen(
    own: Any, scene: Kit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from penumbra import catalogue
    from penumbra.comparison import operators, running

    monkeypatch.setenv("PENUMBRA_CACHE", str(tmp_path))
    scene.scene.penumbra.reference_error = 0.05
    kept = scene.scene.penumbra_comparison
    kept.scale, kept.timing_seconds = 100, 0.05
    for info in catalogue.techniques():
        setattr(kept.techniques, info["id"], info["id"] == "shadow_map")
    own.view_by = "rays"
    made = running.Running(operators.order_of(bpy.context))
    made.run()
    assert made.problem == ""
    assert made.comparison is not None
    assert made.comparison.environment["view_by"] == "rays"
