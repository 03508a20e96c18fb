"""What must hold of every technique on any scene that can be written down: random scenes, shrunk to the least that
fails.

`PENUMBRA_PROPERTIES=deep pytest tests/python/test_properties.py` looks for hours instead of seconds; with
`--hypothesis-verbosity=verbose -s` the last example printed is the one that crashed.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes_at_random import (
    IDENTITY,
    CameraSpec,
    InstanceSpec,
    LightSpec,
    MeshSpec,
    SceneSpec,
    changed,
    cheap,
    looking,
    scenes,
    settings_of,
    sheet,
)

Image = npt.NDArray[np.float32]
Info = dict[str, Any]

INFOS: dict[str, Info] = (
    {info["id"]: info for info in importlib.import_module("penumbra_core").techniques()}
    if importlib.util.find_spec("penumbra_core")
    else {}
)
CHEAP = {technique: cheap(info) for technique, info in INFOS.items()}
every_technique = pytest.mark.parametrize("technique", INFOS)


@pytest.fixture(scope="module")
def renderer(core: Any, working_machine: None) -> Any:
    return core.Renderer()


@pytest.fixture(scope="module")
def other_renderer(core: Any, working_machine: None) -> Any:
    """Its scenes share no mesh with the first one's, so nothing is kept that could be stale."""
    return core.Renderer()


def visibility(core: Any, renderer: Any, scene: Any, technique: str, settings: Info, **more: Any) -> Image | None:
    """V of the scene's light, or None where scene, light or settings are refused in one sentence."""
    try:
        renderer.set_scene(scene)
        if reason := renderer.supports(0, technique):
            assert_sentence(reason)
            return None
        image: Image = renderer.visibility(0, technique, settings, statistics=False, **more)["visibility"]
    except (core.InvalidScene, core.InvalidSettings) as refusal:
        assert_sentence(str(refusal))
        return None
    assert image.shape == (scene.camera.height_px, scene.camera.width_px) and image.dtype == np.float32
    assert np.isfinite(image).all() and image.min() >= 0.0 and image.max() <= 1.0
    return image


def assert_sentence(text: str) -> None:
    assert text.strip() == text and 8 < len(text) < 600 and "\n" not in text, text


def assert_same(one: Image | None, two: Image | None) -> None:
    """Bit for bit."""
    assert (one is None) == (two is None)
    if one is not None and two is not None:
        different = np.argwhere(one != two)
        assert not len(different), [(tuple(at), one[tuple(at)], two[tuple(at)]) for at in different[:8]]


BIAS = frozenset({"bias", "bias_scale", "bias_constant", "slope_cap", "receiver_plane"})
"""With these a map can be told to shade lit surfaces or to look beside the point; what is left out then is an error."""


@every_technique
@given(data=st.data())
def test_v_is_a_share_whatever_the_settings(core: Any, renderer: Any, technique: str, data: st.DataObject) -> None:
    spec, settings = data.draw(scenes(), "scene"), data.draw(settings_of(INFOS[technique]), "settings")
    visibility(core, renderer, spec.build(core), technique, settings)


@every_technique
@given(data=st.data())
def test_leaving_nothing_out_changes_no_pixel(core: Any, renderer: Any, technique: str, data: st.DataObject) -> None:
    spec, settings = data.draw(scenes(), "scene"), data.draw(settings_of(INFOS[technique], BIAS), "settings")
    scene = spec.build(core)
    planned = visibility(core, renderer, scene, technique, settings)
    everything = visibility(core, renderer, scene, technique, settings, keep_everything=True)
    if everything is not None:  # more maps than a device has layers are refused, and were perhaps not needed
        assert_same(planned, everything)


@every_technique
@given(spec=scenes(), order=st.permutations(range(20)))
def test_neither_a_second_time_nor_the_order_of_triangles_changes_a_pixel(
    core: Any, renderer: Any, other_renderer: Any, technique: str, spec: SceneSpec, order: list[int]
) -> None:
    first = visibility(core, renderer, spec.build(core), technique, CHEAP[technique])
    assert_same(first, visibility(core, renderer, spec.build(core), technique, CHEAP[technique]))
    assert_same(first, visibility(core, other_renderer, spec.build(core, order=order), technique, CHEAP[technique]))


@every_technique
@given(spec=scenes(), power=st.integers(-12, 12))
def test_the_unit_of_length_changes_no_pixel(
    core: Any, renderer: Any, technique: str, spec: SceneSpec, power: int
) -> None:
    first = visibility(core, renderer, spec.build(core), technique, CHEAP[technique])
    scaled = spec.build(core, scale=2.0**power)
    assert_same(first, visibility(core, renderer, scaled, technique, CHEAP[technique]))


@every_technique
@given(spec=scenes(exact=True), place=st.sampled_from([0.25, -1024.0, 2.0**20]))
def test_the_place_of_a_scene_changes_no_picture(
    core: Any, renderer: Any, technique: str, spec: SceneSpec, place: float
) -> None:
    first = visibility(core, renderer, spec.build(core), technique, CHEAP[technique])
    moved = visibility(core, renderer, spec.build(core, offset=(place, -place, place)), technique, CHEAP[technique])
    assert (first is None) == (moved is None)
    # A sun's direction and a camera's axes are no round numbers: products with them round, in float64.
    if first is not None and moved is not None:
        np.testing.assert_allclose(moved, first, rtol=0.0, atol=1e-4)


@every_technique
@given(
    first=scenes(),
    edits=st.lists(st.tuples(st.sampled_from(["camera", "light", "meshes", "places"]), scenes()), max_size=4),
)
def test_a_scene_reached_by_edits_looks_as_one_made_at_once(
    core: Any, renderer: Any, other_renderer: Any, technique: str, first: SceneSpec, edits: list[tuple[str, SceneSpec]]
) -> None:
    spec = first
    made: dict[MeshSpec, Any] = {}
    visibility(core, renderer, spec.build(core, made=made), technique, CHEAP[technique])
    for what, other in edits:
        spec = changed(spec, other, what)
        edited = visibility(core, renderer, spec.build(core, made=made), technique, CHEAP[technique])
        assert_same(visibility(core, other_renderer, spec.build(core), technique, CHEAP[technique]), edited)


# --- what was found --------------------------------------------------------------------------------------------------


def test_faces_kept_for_nothing_do_not_widen_fixed_smoothies(core: Any, renderer: Any) -> None:
    blade = ((1e-06, 0.0, 0.0, -0.25), (0.0, 1.0, 0.0, -0.5625), (0.0, 0.0, 1.0, 0.75), (0.0, 0.0, 0.0, 1.0))
    upright = MeshSpec(((1.0, -2.0, -1.0), (1.0, 2.0, -1.0), (1.0, 0.0, 1.0)), ((0, 1, 2),))
    light = {"position_ws": (-1.5, -0.8125, 3.75), "radius_m": 0.25}
    camera = looking((0.0, -7.0, 5.0), (0.0, 0.0, 0.25), math.pi)
    view = {"orthographic": True, "half_width_m": 3.0, "width_px": 24, "height_px": 18, "pixel_aspect": 3.0}
    parts = (InstanceSpec(sheet(4.0), IDENTITY), InstanceSpec(upright, blade))
    spec = SceneSpec(parts, LightSpec("point", light), CameraSpec(camera, {"near_m": 0.1, "far_m": 100.0} | view))
    settings = {"map_size": 64, "width": "fixed", "remap": False, "t": 0.5}
    planned = visibility(core, renderer, spec.build(core), "smoothies", settings)
    everything = visibility(core, renderer, spec.build(core), "smoothies", settings, keep_everything=True)
    assert planned is not None and planned.min() < 1.0
    assert_same(planned, everything)


def test_penumbra_maps_gather_texels_also_where_no_penumbra_is_drawn(core: Any, renderer: Any) -> None:
    quad = InstanceSpec(
        sheet(1.0), ((0.8, 0.6, 0.0, 0.0), (-0.6, 0.8, 0.0, 0.0), (0.0, 0.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0))
    )
    light = LightSpec("point", {"position_ws": (0.3, 0.2, 4.0), "radius_m": 0.0})
    camera = CameraSpec(
        looking((0.0, -7.0, 5.0), (0.0, 0.0, 0.0)), {"width_px": 48, "height_px": 36, "tan_half_width": 0.5}
    )
    spec = SceneSpec((InstanceSpec(sheet(4.0), IDENTITY), quad), light, camera)
    settings = {"map_size": 64, "filter": "gathered"}
    planned = visibility(core, renderer, spec.build(core), "penumbra_maps", settings)
    assert planned is not None and ((planned > 0.0) & (planned < 1.0)).any()
    assert_same(planned, visibility(core, renderer, spec.build(core), "penumbra_maps", settings, keep_everything=True))
