"""Whatever is handed to the core is taken or refused: a class of penumbra_core.Error, a TypeError or a ValueError, with
words in it, and the process lives on. Nothing is rendered here that is not small."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scenes_at_random import SceneSpec, many, scenes, sheet

texts = st.sampled_from(["", "pcf", "light", "x" * 5000, "a\nb", "\x00", "\ud800", "é"]) | st.text(max_size=8)
numbers = (
    st.sampled_from([0, -1, 1, 2**31 - 1, 2**31, -(2**31) - 1, 2**63, 10**400, 0.5, -0.0, 1e-320, 1e38, 3.5e38, 1e308,
                     math.nan, math.inf, -math.inf])
    | st.integers()
    | st.floats()
)  # fmt: skip
anything = st.recursive(
    st.none() | st.booleans() | numbers | texts | st.binary(max_size=4) | st.complex_numbers() | st.builds(object),
    lambda inner: (
        st.lists(inner, max_size=4) | st.tuples(inner, inner, inner) | st.dictionaries(texts, inner, max_size=2)
    ),
    max_leaves=6,
)
shapes = st.sampled_from(
    [(4, 4), (3, 3), (4, 3), (2, 3), (2,), (6,), (6, 3), (0, 3), (0,), (1, 3), (3, 0), (2, 3, 1), ()]
)
kinds = st.sampled_from(["f4", "f8", "f2", "i8", "i1", "u1", "u2", "u4", "u8", "?", "c8", "U3", "S3", "M8[s]"])
any_arrays = st.builds(
    lambda array, way: {0: array, 1: array[::-1] if array.ndim else array, 2: np.asfortranarray(array)}[way],
    shapes.flatmap(lambda shape: kinds.flatmap(lambda kind: arrays.arrays(kind, shape))),
    st.integers(0, 2),
)


@pytest.fixture(scope="module")
def renderer(core: Any, working_machine: None) -> Any:
    return core.Renderer()


def attempt(core: Any, call: Callable[[], Any]) -> Any:
    """What the call returns, or None for a refusal as the module promises it."""
    try:
        return call()
    except (core.Error, TypeError, ValueError) as refusal:
        if not str(refusal).strip():
            pytest.fail(f"{type(refusal).__name__} without a word")
        return None


def small_scene(core: Any) -> Any:
    scene = core.Scene()
    mesh = core.Mesh("floor", np.array(sheet(4.0).positions, np.float32), np.array(sheet(4.0).triangles, np.uint32))
    scene.add_instance("floor", mesh, np.eye(4), np.full((1, 3), 0.8, np.float32))
    light = core.Light()
    light.position_ws, light.radius_m = (0.0, 0.0, 3.0), 0.2
    scene.add_light(light)
    above = np.eye(4)
    above[2, 3] = 8.0
    scene.camera.world_from_camera = above
    scene.camera.width_px, scene.camera.height_px = 16, 12
    return scene


def ask_all(core: Any, renderer: Any, scene: Any) -> None:
    """Everything that only needs a scene; if the border lets it in, it must be fit to be drawn."""
    assert scene.triangle_count >= 0 and scene.instance_count >= 0
    attempt(core, scene.digest)
    attempt(core, scene.validate)
    camera = scene.camera
    if camera.width_px * camera.height_px > 4096:
        return
    attempt(core, lambda: renderer.set_scene(scene))
    view = renderer.view()
    assert np.isfinite(view.position_cr).all() and np.isfinite(view.normal_ws).all()
    for technique, settings in (("shadow_map", {"map_size": 16}), ("ray_traced", {"rays": 4})):
        made = attempt(core, lambda name=technique, given=settings: renderer.visibility(0, name, given))
        if made is not None:
            v = made["visibility"]
            assert np.isfinite(v).all() and v.min() >= 0.0 and v.max() <= 1.0


@many
@given(positions=any_arrays | anything, triangles=any_arrays | anything, normals=st.none() | any_arrays,
       materials=st.none() | any_arrays | anything, name=texts | anything)  # fmt: skip
@example(np.zeros((4, 3), np.float32), np.array([[0, 1, 2**32]]), None, None, "wraps round")
@example(np.zeros((4, 3), np.float32), np.array([[0.0, 1.5, 2.0]]), None, None, "is cut")
@example(np.zeros((4, 3), np.float32), np.array([[0, 1, 2]]), None, np.array([70000]), "wraps round")
def test_any_arrays_are_a_mesh_or_are_refused(
    core: Any, positions: Any, triangles: Any, normals: Any, materials: Any, name: Any
) -> None:
    mesh = attempt(core, lambda: core.Mesh(name, positions, triangles, normals, materials))
    if mesh is not None:
        assert mesh.vertex_count == len(positions) and mesh.triangle_count == len(triangles)
        # What went in unchanged: no index was wrapped round or cut.
        whole = np.asarray(triangles)
        assert whole.size == 0 or (whole.dtype.kind in "uib" and whole.min() >= 0 and whole.max() < len(positions))
        slots = np.asarray(materials if materials is not None else [])
        assert slots.size == 0 or (slots.min() >= 0 and slots.max() < 2**16)


@many
@given(mesh=st.just("mesh") | anything, matrix=any_arrays | anything, albedo=any_arrays | anything,
       flags=st.tuples(st.booleans(), st.booleans(), st.booleans()))  # fmt: skip
@example(None, np.eye(4), np.ones((1, 3)), (True, True, True))
def test_any_instance_is_one_or_is_refused(
    core: Any, renderer: Any, mesh: Any, matrix: Any, albedo: Any, flags: tuple[bool, bool, bool]
) -> None:
    scene = small_scene(core)
    if mesh == "mesh":
        mesh = core.Mesh("m", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.uint32))
    attempt(core, lambda: scene.add_instance("any", mesh, matrix, albedo, *flags))
    attempt(core, lambda: scene.set_transform(0, matrix))
    attempt(core, lambda: scene.set_transform(matrix, np.eye(4)))
    ask_all(core, renderer, scene)


def test_an_object_that_was_never_initialised_is_refused_wherever_it_is_used(core: Any, renderer: Any) -> None:
    scene = small_scene(core)
    bound = [core.Camera, core.Light, core.Mesh, core.Renderer, core.Scene, core.View]
    assert bound == [found for name, found in sorted(vars(core).items())
                     if isinstance(found, type) and not issubclass(found, Exception)]  # fmt: skip
    for kind in bound:
        empty = kind.__new__(kind)
        for name in dir(kind):
            member = getattr(kind, name)
            if name.startswith("_"):
                continue
            with pytest.raises(TypeError):  # some methods for want of their other arguments
                member(empty) if callable(member) else getattr(empty, name)
    empty = {kind: kind.__new__(kind) for kind in bound}
    for use in (
        empty[core.Scene].validate,
        lambda: renderer.set_scene(empty[core.Scene]),
        lambda: core.exact_visibility(empty[core.Scene], 0, np.zeros((1, 3)), np.ones((1, 3))),
        lambda: scene.add_light(empty[core.Light]),
        lambda: setattr(scene, "lights", [empty[core.Light]]),
        lambda: setattr(scene, "camera", empty[core.Camera]),
        lambda: scene.add_instance("m", empty[core.Mesh], np.eye(4), np.ones((1, 3))),
        lambda: setattr(empty[core.Light], "kind", "sun"),
        lambda: empty[core.Renderer].view(),
    ):
        with pytest.raises(TypeError, match="__init__ never filled; call its class"):
            use()
    empty[core.Scene].__init__()
    empty[core.Scene].validate()


LIGHT = ["name", "kind", "position_ws", "direction_ws", "half_u_ws", "half_v_ws", "corners_ws", "radius_m",
         "sun_angle_rad", "spot_angle_rad", "spot_blend", "spot_stretch", "power_w", "casts_shadow"]  # fmt: skip
CAMERA = ["name", "world_from_camera", "orthographic", "tan_half_width", "half_width_m", "shift", "pixel_aspect",
          "near_m", "far_m", "width_px", "height_px", "pixel_offset"]  # fmt: skip


def test_no_member_is_missing_above(core: Any) -> None:
    assert set(LIGHT) == {name for name in dir(core.Light) if not name.startswith("_")}
    assert set(CAMERA) == {name for name in dir(core.Camera) if not name.startswith("_")}


vectors = st.tuples(numbers, numbers, numbers)


@many
@given(
    spec=scenes(),
    members=st.dictionaries(st.sampled_from(LIGHT), anything | vectors | any_arrays, min_size=1, max_size=3),
)
def test_any_light_is_one_or_is_refused(core: Any, renderer: Any, spec: SceneSpec, members: dict[str, Any]) -> None:
    scene = spec.build(core)
    (light,) = scene.lights
    for name, value in members.items():
        attempt(core, lambda name=name, value=value: setattr(light, name, value))
    scene.lights = [light]
    ask_all(core, renderer, scene)


@many
@given(members=st.dictionaries(st.sampled_from(CAMERA), anything | vectors | any_arrays, min_size=1, max_size=3))
def test_any_camera_is_one_or_is_refused(core: Any, renderer: Any, members: dict[str, Any]) -> None:
    scene = small_scene(core)
    for name, value in members.items():
        attempt(core, lambda name=name, value=value: setattr(scene.camera, name, value))
    ask_all(core, renderer, scene)


@many
@given(
    technique=texts | anything,
    settings=st.dictionaries(texts | numbers | st.none(), anything, max_size=3) | anything,
    light=numbers | anything,
)
@example("pcf", {"kernel": 10**12}, 0)
@example("pcf", {5: 1}, 0)
@example("pcf", {"bias": "\ud800"}, 0)
@example("pcf", {"bias_scale": math.nan}, 0)
def test_any_order_is_carried_out_or_refused(
    core: Any, renderer: Any, technique: Any, settings: Any, light: Any
) -> None:
    renderer.set_scene(small_scene(core))
    attempt(core, lambda: renderer.visibility(light, technique, settings))
    attempt(core, lambda: renderer.supports(light, technique))
    attempt(core, lambda: renderer.mask(light))
    attempt(core, lambda: renderer.summary(light))
    attempt(core, lambda: renderer.debug_images(light, technique, settings, [technique]))
    attempt(core, lambda: renderer.bake(light, technique, settings))


@many
@given(data=st.data())
def test_any_value_of_a_setting_is_taken_or_refused(core: Any, renderer: Any, data: st.DataObject) -> None:
    renderer.set_scene(small_scene(core))
    info = data.draw(st.sampled_from(core.techniques()))
    setting = data.draw(st.sampled_from(info["settings"]))
    value = data.draw(anything.filter(lambda v: not isinstance(v, int) or not 256 < v < 2**31))
    attempt(core, lambda: renderer.visibility(0, info["id"], {setting["id"]: value}))


@many
@given(
    error=numbers,
    seed=numbers,
    rays=numbers.filter(lambda n: not 4096 < n < 2**31),
    runs=st.tuples(numbers, numbers),
    seconds=numbers,
)
@example(0.002, 1, 64, (5, 10**9), math.nan)
@example(0.002, 1, 64, (-3, -5), 0.0)
def test_any_limits_of_measuring_are_kept_or_refused(
    core: Any, renderer: Any, error: Any, seed: Any, rays: Any, runs: tuple[Any, Any], seconds: Any
) -> None:
    renderer.set_scene(small_scene(core))
    attempt(core, lambda: renderer.reference(0, standard_error=error, seed=seed, max_rays_per_pixel=rays))
    if seconds != seconds or seconds < 0.01:
        attempt(core, lambda: renderer.measure(0, [("shadow_map", {"map_size": 16})], max_seconds=seconds,
                                               min_runs=runs[0], max_runs=runs[1]))  # fmt: skip


@many
@given(images=st.lists(any_arrays, max_size=2), truth=any_arrays, deviation=st.none() | any_arrays, mask=any_arrays)
def test_any_images_are_measured_or_refused(core: Any, images: Any, truth: Any, deviation: Any, mask: Any) -> None:
    attempt(core, lambda: core.measure_errors(images, truth, deviation, mask))


@many
@given(times=st.lists(st.floats(), max_size=6), errors=st.lists(st.floats(), max_size=6))
def test_a_front_has_a_mark_for_each_record(core: Any, times: list[float], errors: list[float]) -> None:
    front = attempt(core, lambda: core.pareto_front(times, errors))
    assert (front is None) == (len(times) != len(errors)) and (front is None or len(front) == len(times))


@many
@given(points=any_arrays, normals=any_arrays, kind=st.sampled_from(["rectangle", "polygon", "point"]))
def test_any_points_have_an_exact_visibility_or_are_refused(core: Any, points: Any, normals: Any, kind: str) -> None:
    scene = small_scene(core)
    light = core.Light()
    light.kind, light.position_ws = kind, (0.0, 0.0, 3.0)
    light.half_u_ws, light.half_v_ws = (0.5, 0.0, 0.0), (0.0, 0.5, 0.0)
    light.corners_ws = [(0.0, 0.0, 3.0), (1.0, 0.0, 3.0), (0.0, 1.0, 3.0)]
    scene.add_light(light)
    found = attempt(core, lambda: core.exact_visibility(scene, 1, points, normals))
    if found is not None:
        assert np.isfinite(found["area"]).all() and np.isfinite(found["irradiance"]).all()
