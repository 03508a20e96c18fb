"""The comparer on a scene made for the core alone: no Blender, no files."""

from __future__ import annotations

import io
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from must_run import skip
from penumbra.compare import Comparer, Options
from penumbra.progress import Progress


@pytest.fixture(scope="module")
def renderer(core: Any) -> Any:
    try:
        return core.Renderer("")
    except core.DeviceError as error:
        skip(str(error))


def export(core: Any, width: int = 96, height: int = 64) -> Any:
    """A plate one metre above a floor, under a square light; what bridge.read_scene would return."""
    scene = core.Scene()

    def square(name: str, half: float, z: float) -> None:
        corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], np.float32)
        mesh = core.Mesh(name, corners, np.array([(0, 1, 2), (0, 2, 3)], np.uint32))
        placed = np.eye(4)
        placed[2, 3] = z
        scene.add_instance(name, mesh, placed, albedo=np.full((1, 3), 0.8, np.float32))

    square("Floor", 5, 0)
    square("Plate", 0.7, 1)
    light = core.Light()
    light.name, light.kind = "Key", "rectangle"
    light.position_ws, light.direction_ws = (0, 0, 4), (0, 0, -1)
    light.half_u_ws, light.half_v_ws = (0.5, 0, 0), (0, -0.5, 0)
    light.power_w = (100, 100, 100)
    scene.add_light(light)
    camera = core.Camera()
    camera.name = "Camera"
    tilt = np.radians(50)
    at = np.eye(4)
    at[:3, :3] = [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    at[:3, 3] = (0, -5, 4.2)
    camera.world_from_camera = at
    camera.width_px, camera.height_px = width, height
    scene.camera = camera
    return SimpleNamespace(
        scene=scene, notes=[], lights=["Key"], camera="Camera", size=(width, height), triangles=4, frame=1
    )


class Broken:
    """The renderer, of which one call fails for one technique."""

    def __init__(self, renderer: Any, core: Any, call: str, technique: str) -> None:
        self._renderer, self._error = renderer, core.DeviceError
        self._call, self._technique = call, technique

    def __getattr__(self, name: str) -> Any:
        inner = getattr(self._renderer, name)
        if name != self._call:
            return inner

        def call(light: int, what: Any = None, *more: Any, **named: Any) -> Any:
            ids = [what] if isinstance(what, str) else [job[0] for job in what or []]
            if self._technique in ids or not self._technique:
                raise self._error("the device was lost.\nmore lines")
            return inner(light, what, *more, **named)

        return call


FAST = Options(techniques=("shadow_map", "ray_traced"), reference_error=0.05, use_cache=False, timing_seconds=0.05)


def compared(core: Any, renderer: Any, options: Options = FAST) -> tuple[Any, Comparer]:
    comparer = Comparer(core, renderer, options, Progress(1.0, io.StringIO(), show=False))
    return comparer.compare(export(core), "plate"), comparer


def test_a_comparison_has_a_complete_record_per_technique(core: Any, renderer: Any) -> None:
    scene, comparer = compared(core, renderer)
    assert comparer.failures == []
    (light,) = scene.lights
    assert [record.status for record in light.records] == ["ok", "ok"]
    assert light.size_m == pytest.approx([1.0, 1.0])
    for record in light.records:
        assert set(record.time_ms) == {"setup", "dynamic", "static", "kept", "view"}
        assert record.visibility is not None
        assert record.visibility.shape == (64, 96)
        assert record.area is not None
        assert record.area["penumbra_pixels"] > 20
        assert any(step.state == "run" for step in record.plan)
    assert [statistic.id for statistic in light.records[1].statistics] == ["rays"]
    assert light.records[0].seeds == 1
    assert light.records[1].seeds == 4
    assert light.irradiance is not None
    assert light.irradiance.max() > 0


def test_savings_are_measured_where_they_are_asked_for(core: Any, renderer: Any) -> None:
    assert all(record.everything_ms == {} for record in compared(core, renderer)[0].lights[0].records)
    scene, _ = compared(core, renderer, replace(FAST, measure_savings=True))
    for record in scene.lights[0].records:
        assert set(record.everything_ms) == {"dynamic", "static"}
        saved = record.saved_ms()
        assert saved == record.everything_ms["dynamic"].median - record.time_ms["dynamic"].median
        assert any(step.state == "run" for step in record.plan)
    whole, _ = compared(core, renderer, replace(FAST, measure_savings=True, keep_everything=True))
    assert whole.lights[0].records[0].saved_ms() is None, "nothing is left out, so nothing is saved"


def test_an_unchanged_frame_is_handed_over_where_it_is_asked_for(core: Any, renderer: Any) -> None:
    scene = export(core).scene
    renderer.set_scene(scene)
    first = renderer.visibility(0, "shadow_map", reuse=True)
    renderer.set_scene(scene)
    before = renderer.work()
    second = renderer.visibility(0, "shadow_map", reuse=True)
    assert (first["kept"], second["kept"]) == (False, True)
    assert renderer.work() == before | {"frames_kept": before["frames_kept"] + 1}
    assert all(step["state"] == "left_out" for step in second["plan"])
    assert np.array_equal(first["visibility"], second["visibility"])
    assert not renderer.visibility(0, "shadow_map")["kept"]
    with pytest.raises(core.InvalidSettings, match="no rule"):
        renderer.visibility(0, "shadow_map", keep_rules=["no-such-rule"])


def test_a_technique_that_fails_is_recorded_and_the_others_go_on(core: Any, renderer: Any) -> None:
    scene, comparer = compared(core, Broken(renderer, core, "visibility", "shadow_map"))
    hard, rays = scene.lights[0].records
    assert (hard.status, hard.reason) == ("failed", "the device was lost")
    assert rays.status == "ok"
    assert "dynamic" in rays.time_ms
    assert [failure.what for failure in comparer.failures] == ["plate, Key, shadow_map"]


def test_a_technique_that_fails_while_it_is_timed_does_not_spoil_the_others(core: Any, renderer: Any) -> None:
    scene, comparer = compared(core, Broken(renderer, core, "measure", "ray_traced"))
    hard, rays = scene.lights[0].records
    assert hard.status == "ok"
    assert "dynamic" in hard.time_ms
    assert (rays.status, rays.reason) == ("failed", "timing: the device was lost")
    assert len(comparer.failures) == 1


def test_what_does_not_fit_together_is_timed_all_the_same(
    core: Any, renderer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("penumbra.compare.TIMING_MEMORY", 1)
    scene, comparer = compared(core, renderer)
    assert comparer.failures == []
    for record in scene.lights[0].records:
        assert {"setup", "dynamic", "static", "view"} <= record.time_ms.keys()


def test_a_light_without_a_reference_fails_all_its_records(core: Any, renderer: Any) -> None:
    scene, comparer = compared(core, Broken(renderer, core, "reference", ""))
    assert {record.status for record in scene.lights[0].records} == {"failed"}
    assert len(comparer.failures) == 1


def test_a_failed_comparison_still_makes_a_report(core: Any, renderer: Any, tmp_path: Any) -> None:
    from penumbra import environment
    from penumbra.records import Comparison
    from penumbra.report import ReportWriter

    for number, broken in enumerate(
        (Broken(renderer, core, "reference", ""), Broken(renderer, core, "measure", "ray_traced"))
    ):
        scene, comparer = compared(core, broken)
        comparison = Comparison(environment.collect(core, renderer, ["compare"]), {}, [scene], comparer.failures)
        writer = ReportWriter(tmp_path / str(number))
        writer.add_scene(scene)
        assert "the device was lost" in writer.finish(comparison).read_text()


def test_what_was_asked_for_is_what_was_used(core: Any, renderer: Any) -> None:
    options = Options(
        techniques=("pcf",), settings={"pcf": {"kernel": 3}}, reference_error=0.05, use_cache=False, timing_seconds=0.05
    )
    scene, _ = compared(core, renderer, options)
    (record,) = scene.lights[0].records
    assert record.settings["kernel"] == 3
    assert set(record.settings) == {
        setting["id"] for info in core.techniques() if info["id"] == "pcf" for setting in info["settings"]
    }


def test_the_digest_tells_scenes_apart_and_not_their_reading(core: Any) -> None:
    a, b, c = export(core).scene, export(core).scene, export(core, width=97).scene
    assert a.digest() == b.digest()
    assert a.digest() != c.digest()
