"""The viewport's parts that need no window: its camera, and the thread that makes its pictures."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
import penumbra_core as core
import pytest
from blender_kit import Kit
from penumbra import bridge, picture
from penumbra.picture import Wanted
from penumbra.progress import Progress
from penumbra.read.view_camera import view_camera
from penumbra.viewport import worker as worker_module
from penumbra.viewport.pictures import LARGEST_HALF, Pictures, displayable
from penumbra.viewport.worker import Question, Worker

SIZE = (96, 64)


def scene(kit: Kit) -> None:
    kit.plane("Floor", half=5)
    kit.cube("Box", half=0.5, at=(0.3, 0, 1.5))
    kit.light("POINT", energy=200, at=(1, 1, 4), shadow_soft_size=0.3)


@pytest.mark.parametrize(
    "lens",
    [
        {"lens": 35.0},
        {"lens": 50.0, "shift_x": 0.2, "shift_y": -0.1},
        {"lens": 20.0, "sensor_fit": "VERTICAL"},
        {"type": "ORTHO", "ortho_scale": 4.0, "shift_x": 0.1, "shift_y": 0.05},
    ],
)
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (2.0, 1.0)])
def test_the_matrices_of_a_camera_give_the_camera_itself(kit: Kit, lens: dict[str, Any], aspect: Any) -> None:
    scene(kit)
    render = kit.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE, 100
    render.pixel_aspect_x, render.pixel_aspect_y = aspect
    obj = kit.camera(at=(0.5, -3, 6), turn=(0.5, 0.1, 0.2), clip_start=0.5, clip_end=50, **lens)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    expected = bridge.read_scene(depsgraph).scene.camera
    window = obj.calc_matrix_camera(depsgraph, x=SIZE[0], y=SIZE[1], scale_x=aspect[0], scale_y=aspect[1])
    points = np.array([[-5.0, -5, 0], [5, 5, 2]])
    made = view_camera(core, obj.matrix_world.inverted(), window, SIZE, points)
    assert made.orthographic == expected.orthographic
    assert made.shift == pytest.approx(expected.shift, abs=1e-6)
    assert made.pixel_aspect == pytest.approx(expected.pixel_aspect, rel=1e-5)
    if made.orthographic:
        assert made.half_width_m == pytest.approx(expected.half_width_m, rel=1e-5)
        assert np.allclose(made.world_from_camera[:3, :3], expected.world_from_camera[:3, :3], atol=1e-6)
        moved = made.world_from_camera[:3, 3] - expected.world_from_camera[:3, 3]
        assert np.allclose(np.cross(moved, made.world_from_camera[:3, 2]), 0, atol=1e-5), "only backwards"
    else:
        assert made.tan_half_width == pytest.approx(expected.tan_half_width, rel=1e-5)
        assert made.near_m == pytest.approx(0.5, rel=1e-3) and made.far_m == pytest.approx(50, rel=1e-2)
        assert np.allclose(made.world_from_camera, expected.world_from_camera, atol=1e-5)


def test_an_orthographic_eye_stands_before_all_there_is() -> None:
    view = np.eye(4)
    window = np.diag([1.0, 1.0, -0.001, 1.0])  # from -1000 to 1000 metres, as Blender's own
    points = np.array([[0.0, 0, 70], [0, 0, -30]])
    made = view_camera(core, view, window, SIZE, points)
    assert made.world_from_camera[2, 3] - made.near_m > 70
    assert made.world_from_camera[2, 3] - made.far_m < -30


def test_a_part_of_the_region_sees_that_part() -> None:
    window = np.array([[1.5, 0, 0.1, 0], [0, 2.0, -0.2, 0], [0, 0, -1.02, -0.2], [0, 0, -1, 0]])
    points = np.zeros((1, 3))
    whole = view_camera(core, np.eye(4), window, (80, 40), points)
    part = view_camera(core, np.eye(4), window, (40, 10), points, (0.5, 0.25, 1.0, 0.5))

    def tangents(camera: Any) -> tuple[float, float, float, float]:
        half = camera.tan_half_width
        up = half * camera.height_px / camera.width_px * camera.pixel_aspect
        x, y = (2 * half * s for s in camera.shift)
        return x - half, y - up, x + half, y + up

    left, bottom, right, top = tangents(whole)
    across, high = right - left, top - bottom
    expected = (left + across / 2, bottom + high / 4, right, bottom + high / 2)
    assert tangents(part) == pytest.approx(expected)


def test_pixels_for_the_screen_are_finite_and_fit_half_floats() -> None:
    colour = np.array([[[np.nan, np.inf, -np.inf, 1.0], [1e6, 70000.0, 0.5, 1.0]]], np.float32)
    shown = displayable(colour)
    assert shown.tolist() == [[[0, LARGEST_HALF, 0, 1], [LARGEST_HALF, LARGEST_HALF, 0.5, 1]]]
    assert np.isfinite(shown.astype(np.float16)).all()
    assert shown.dtype == np.float32 and shown.flags.c_contiguous


@pytest.fixture
def asked(kit: Kit) -> Any:
    """A viewport and a way to ask it."""
    scene(kit)
    kit.camera(at=(0, -3, 6), turn=(0.45, 0, 0))
    bpy.context.view_layer.update()
    export = bridge.read_scene(bpy.context.evaluated_depsgraph_get())
    worker: Worker[Any] = Worker()
    pictures = Pictures()

    def camera_of(x: float) -> Callable[[tuple[int, int]], Any]:
        def camera(size: tuple[int, int]) -> Any:
            made = export.scene.copy().camera
            matrix = made.world_from_camera
            matrix[0, 3] += x
            made.world_from_camera = matrix
            made.width_px, made.height_px = size
            return made

        return camera

    def ask(key: Any, x: float = 0.0, wanted: Wanted | None = None, smaller: int = 2, **machine: str) -> None:
        own = replace(export, scene=export.scene.copy())
        wanted = wanted or Wanted(technique="shadow_map", settings={})
        worker.ask(pictures.question(key, own, camera_of(x), SIZE, wanted, smaller=smaller, **machine))

    ask.worker, ask.export, ask.camera = worker, export, camera_of(0.0)  # type: ignore[attr-defined]
    yield ask
    worker.close()
    wait_for(lambda: not threads_of_viewports())


def threads_of_viewports() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "Penumbra viewport"]


def wait_for(what: Callable[[], Any], seconds: float = 20.0) -> Any:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(0.005)
    raise AssertionError("waited in vain")


def finished(worker: Worker[Any], key: Any, samples: int = 1) -> Any:
    def found() -> Any:
        shown = worker.shown
        return shown if shown and shown.key == key and shown.size == SIZE and shown.samples == samples else None

    return wait_for(found)


def test_the_full_picture_is_the_one_that_a_render_makes(asked: Any) -> None:
    asked("a")
    shown = finished(asked.worker, "a")
    asked.export.scene.camera = asked.camera(SIZE)
    wanted = Wanted(technique="shadow_map", settings={})
    direct = picture.Painter(core.Renderer(), asked.export, wanted, Progress(show=False)).sample(0)
    assert np.array_equal(shown.pixels, displayable(direct.planes["Combined"]))
    assert shown.pixels[..., 0].max() > 0


def test_pixel_samples_follow_one_after_the_other(asked: Any) -> None:
    asked("a", wanted=Wanted(technique="shadow_map", settings={}, pixel_samples=5))
    assert finished(asked.worker, "a", 5).number >= 5


def test_the_newest_question_wins_and_older_ones_end_early(asked: Any) -> None:
    slow = Wanted(technique="ray_traced", settings={"ray_traced": {"rays": 65536}})
    asked("slow", wanted=slow, smaller=1)
    time.sleep(0.2)
    for step in range(20):
        asked(step, x=0.01 * step)
    finished(asked.worker, 19)  # hours of rays were given up


def overtaken(worker: Worker[Any]) -> list[str]:
    """A question during whose work a newer one comes; what becomes of its two answers, and of the newer one's."""
    heard: list[str] = []

    def newer(_renderer: Any, desk: Any) -> None:
        desk.show("newer")

    def older(_renderer: Any, desk: Any) -> None:
        worker.ask(Question("newer", newer))
        for name in ("first", "second"):
            try:
                desk.stop_if_old()
                desk.show(name)
                heard.append(worker.shown)
            except picture.StoppedError:
                heard.append(f"{name} given up")
        raise picture.StoppedError

    worker.ask(Question("older", older))
    wait_for(lambda: worker.shown == "newer")
    return heard


def test_a_turning_view_sees_a_first_picture_of_each_question_that_is_worked_on(
    asked: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_module, "PATIENCE_S", 60.0)
    assert overtaken(asked.worker) == ["first", "second given up"]


def test_an_old_question_that_takes_long_is_given_up(asked: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_module, "PATIENCE_S", 0.0)
    assert overtaken(asked.worker) == ["first given up", "second given up"]


def test_an_error_is_a_sentence_and_the_last_picture_stays(asked: Any) -> None:
    asked("good")
    good = finished(asked.worker, "good")
    asked("bad", device="a device of nobody")
    assert "no device matches" in wait_for(lambda: asked.worker.problem)
    assert asked.worker.shown is good
    asked("again")
    finished(asked.worker, "again")
    assert asked.worker.problem == ""


def test_another_view_makes_the_renderer_anew(asked: Any) -> None:
    worker = asked.worker
    asked("drawn", view_by="raster")
    drawn = finished(worker, "drawn").pixels
    asked("traced", view_by="rays")
    traced = finished(worker, "traced").pixels
    assert drawn[..., 0].max() > 0
    assert np.count_nonzero(np.abs(drawn - traced).max(axis=2) > 1e-3) <= 8
    for view_by in ("raster", "rays"):
        worker.ask(Question(view_by, lambda made, desk: desk.show(made.environment["view_by"]), view_by=view_by))
        wait_for(lambda view_by=view_by: worker.shown == view_by)
    asked("unknown", view_by="ray")
    assert 'unknown view "ray"' in wait_for(lambda: worker.problem)


def test_closing_while_it_works_ends_the_work(asked: Any) -> None:
    slow = Wanted(technique="ray_traced", settings={"ray_traced": {"rays": 65536}})
    asked("slow", wanted=slow, smaller=1)
    time.sleep(0.2)
    assert threads_of_viewports()
    asked.worker.close()
    wait_for(lambda: not threads_of_viewports())  # hours of rays were given up
    asked("later")
    assert not threads_of_viewports()
    assert asked.worker.shown is None
