"""Penumbra maps, smoothies and plateaus on real scenes: the examples, and models where they are at hand."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any

import numpy as np
import penumbra_core as core
import pytest
from penumbra import scenes

ROOT = Path(__file__).resolve().parents[2]
MODELS = Path(os.environ.get("PENUMBRA_MODELS", ROOT.parent / "shared" / "data"))
SCENES = [ROOT / "examples" / f"{name}.blend" for name in ("courtyard", "desk", "plaza")]
SCENES += [MODELS / f"{name}.obj" for name in ("stanford-bunny", "spot", "fandisk", "teapot")]
FAMILY = ("penumbra_maps", "smoothies", "plateaus")
SMALL = {"map_size": 256}

every_scene = pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)


def opened(path: Path) -> Any:
    if not path.is_file():
        pytest.skip(f"{path.name} is not at hand; set PENUMBRA_MODELS to its folder")
    scenes.open_scene(path)
    return scenes.read(size=(128, 72))


@pytest.fixture(scope="module")
def renderer() -> Any:
    return core.Renderer()


def settings_of(technique: str, **more: Any) -> dict[str, Any]:
    known = {setting["id"] for info in core.techniques() if info["id"] == technique for setting in info["settings"]}
    return {key: value for key, value in (SMALL | more).items() if key in known}


def visibility(renderer: Any, light: int, technique: str, **more: Any) -> Any:
    return np.asarray(renderer.visibility(light, technique, settings_of(technique, **more))["visibility"])


@every_scene
def test_v_is_a_share_of_the_light_for_every_light(path: Path, renderer: Any) -> None:
    export = opened(path)
    renderer.set_scene(export.scene)
    for light in range(len(export.lights)):
        for technique in FAMILY:
            for sides in ("outer", "both"):
                image = visibility(renderer, light, technique, sides=sides)
                assert np.isfinite(image).all(), (technique, sides)
                assert image.min() >= 0.0 and image.max() <= 1.0, (technique, sides)


@every_scene
def test_a_light_of_no_size_gives_the_hard_shadow_map(path: Path, renderer: Any) -> None:
    export = opened(path)
    lights = export.scene.lights
    for light in lights:
        light.radius_m = 0.0
        light.sun_angle_rad = 0.0
        light.half_u_ws = light.half_v_ws = (0.0, 0.0, 0.0) if light.kind not in ("spot", "point") else light.half_u_ws
    export.scene.lights = lights
    renderer.set_scene(export.scene)
    for light in range(len(lights)):
        hard = visibility(renderer, light, "shadow_map", bias="slope")
        assert np.array_equal(visibility(renderer, light, "penumbra_maps", bias="slope"), hard)
        assert np.array_equal(visibility(renderer, light, "smoothies", bias="slope", filter="nearest"), hard)


@every_scene
def test_literal_and_exact_penumbra_maps_are_the_same_image(path: Path, renderer: Any) -> None:
    export = opened(path)
    renderer.set_scene(export.scene)
    exact = visibility(renderer, 0, "penumbra_maps", mode="exact", ramp="depth", trim_cones=False)
    literal = visibility(renderer, 0, "penumbra_maps", mode="literal", ramp="depth", facets=64, sheet_parts=32)
    # One quad per sheet is off by up to 0.09 on tilted edges, 32 parts by a tenth of that; texels on an outline flip.
    assert np.percentile(np.abs(exact - literal), 99) < 0.02


@pytest.mark.parametrize("path", SCENES[:3], ids=lambda path: path.stem)
def test_the_order_of_faces_changes_nothing(path: Path, renderer: Any) -> None:
    import bmesh
    import bpy

    export = opened(path)
    renderer.set_scene(export.scene)
    before = {technique: visibility(renderer, 0, technique) for technique in FAMILY}
    shuffle = random.Random(7)
    for mesh in {o.data for o in bpy.context.scene.objects if o.type == "MESH" and not o.modifiers}:
        edited = bmesh.new()
        edited.from_mesh(mesh)
        edited.faces.sort(key=lambda _: shuffle.random())
        edited.to_mesh(mesh)
        edited.free()
    renderer.set_scene(scenes.read(size=(128, 72)).scene)
    for technique in FAMILY:
        assert np.array_equal(visibility(renderer, 0, technique), before[technique]), technique


@every_scene
def test_silhouettes_found_on_the_device_and_on_the_processor_give_one_image(path: Path, renderer: Any) -> None:
    export = opened(path)
    renderer.set_scene(export.scene)
    for technique in FAMILY:
        device = visibility(renderer, 0, technique, silhouettes="gpu")
        processor = visibility(renderer, 0, technique, silhouettes="cpu")
        # Positions are rounded along two ways; an edge within rounding of edge-on may be found on one side alone.
        assert np.mean(np.abs(device - processor) > 1e-3) < 0.002, technique
