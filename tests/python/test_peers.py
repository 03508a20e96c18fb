"""The pure parts of tests/benchmarks/peers.py: pixels compared, V, curves, what is kept, the page."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from peers import curves, exchange, measuring, page, plan, results, sources, visibility
from peers.curves import Sample
from peers.exchange import Light
from peers.measuring import Measured, Store
from peers.plan import Limits, Point

FLOOR_UP = (0.0, 0.0, 1.0)
SQUARE = Light("rectangle", (0, 0, 1), (0, 0, -1), (0.5, 0, 0), (0, 0.5, 0), 0.0, 1.0)


def floor(side: int = 7) -> tuple[Any, Any, Any]:
    """Instance, normal and position of a floor seen from above, a pixel a metre."""
    y, x = np.mgrid[0:side, 0:side].astype(np.float32)
    position = np.stack([x, y, np.zeros_like(x)], axis=-1)
    return np.zeros((side, side), np.int32), np.broadcast_to(np.float32(FLOOR_UP), position.shape).copy(), position


# ------------------------------------------------------------------------------------------------------------- pixels


def test_v_is_one_where_nothing_would_arrive_anyway() -> None:
    v = visibility.visibility(np.float32([[1, 0, 3]]), np.float32([[2, 0, 3]]))
    np.testing.assert_array_equal(v, np.float32([[0.5, 1, 1]]))


def test_a_floor_is_one_surface_but_for_the_image_border() -> None:
    inside = visibility.inside_surfaces(*floor())
    assert inside[1:-1, 1:-1].all()
    assert inside.sum() == 25


@pytest.mark.parametrize("what", ["another object", "a crease", "a step", "nothing"])
def test_pixels_beside_an_edge_are_left_out_and_no_others(what: str) -> None:
    instance, normal, position = floor()
    right = (slice(None), slice(4, None))
    if what == "another object":
        instance[right] = 1
    elif what == "a crease":
        normal[right] = (math.sin(0.05), 0.0, math.cos(0.05))
    elif what == "a step":
        position[right] += np.float32((0, 0, 1))
    else:
        instance[right] = -1
    inside = visibility.inside_surfaces(instance, normal, position)
    assert not inside[:, 3:5].any()
    assert inside[1:-1, 1:3].all()
    assert inside[1:-1, 5].all() == (what != "nothing")


def test_a_tilted_floor_is_one_surface_however_steep() -> None:
    instance, normal, position = floor()
    position[..., 2] = 50 * position[..., 0]
    normal[:] = np.float32((-50, 0, 1)) / math.hypot(50, 1)
    assert visibility.inside_surfaces(instance, normal, position)[1:-1, 1:-1].all()


@pytest.mark.parametrize(("height", "above"), [(0.0, True), (0.99, True), (1.0, False), (2.0, False)])
def test_a_receiver_must_lie_below_all_of_the_light(height: float, above: bool) -> None:
    point, up = np.array([[[3.0, 0.0, height]]]), np.float32([[FLOOR_UP]])
    assert visibility.whole_light_above(SQUARE, point, up)[0, 0] == above


def test_a_wall_whose_plane_cuts_the_light_is_left_out() -> None:
    wall = np.float32([[[1, 0, 0]]])
    for x, above in ((-0.51, True), (-0.49, False), (0.0, False), (0.51, False)):
        assert visibility.whole_light_above(SQUARE, np.array([[[x, 0.0, 0.0]]]), wall)[0, 0] == above


def test_a_sun_must_be_above_the_horizon_by_half_its_angle() -> None:
    sun = Light("sun", (0, 0, 0), (1.0, 0.0, -0.1), (0, 0, 0), (0, 0, 0), 0.18, 1.0)
    up = np.float32([[FLOOR_UP]])
    assert visibility.whole_light_above(sun, np.zeros((1, 1, 3)), up)[0, 0]
    wider = Light("sun", (0, 0, 0), (1.0, 0.0, -0.1), (0, 0, 0), (0, 0, 0), 0.21, 1.0)
    assert not visibility.whole_light_above(wider, np.zeros((1, 1, 3)), up)[0, 0]


# ------------------------------------------------------------------------------------------------------------- curves


def test_the_time_to_a_target_follows_a_power_law_exactly() -> None:
    samples = [Sample(1 / n, 3.0 * n**1.5) for n in (1, 4, 16, 64)]
    for n in (2.0, 7.0, 50.0):
        assert curves.time_to(1 / n, samples) == pytest.approx(3.0 * n**1.5)


def test_points_that_others_beat_do_not_bend_the_curve() -> None:
    good = [Sample(0.1, 10), Sample(0.01, 100)]
    beaten = [Sample(0.1, 50), Sample(0.5, 20), Sample(0.01, 1000)]
    assert curves.staircase(good + beaten) == good
    assert curves.time_to(0.03, good + beaten) == curves.time_to(0.03, good)


def test_nothing_is_claimed_beyond_what_was_measured() -> None:
    samples = [Sample(0.1, 10, "a"), Sample(0.02, 100, "b")]
    assert curves.time_to(0.01, samples) is None
    assert curves.time_to(0.2, samples) == 10
    assert curves.time_to(0.01, []) is None
    assert curves.cheapest(0.05, samples) == samples[1]
    assert curves.cheapest(0.01, samples) is None


# -------------------------------------------------------------------------------------------------------------- scene


def test_the_knot_is_closed_and_the_scene_survives_its_file(tmp_path: Path) -> None:
    scene = sources.knot((64, 48), around=6, along=30)
    knot = scene.parts[1].triangles
    edges = np.sort(np.concatenate([knot[:, [0, 1]], knot[:, [1, 2]], knot[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    scene.save(tmp_path)
    again = exchange.load(tmp_path)
    assert (again.light, again.camera, again.name) == (scene.light, scene.camera, scene.name)
    np.testing.assert_array_equal(again.soup()[1], scene.soup()[1])
    np.testing.assert_array_equal(again.soup()[0], scene.soup()[0])
    bare = (tmp_path / exchange.SOUP_FILE).read_bytes()
    positions, triangles = scene.soup()
    assert len(bare) == 6 * 4 + 30 * 8 + positions.size * 4 + triangles.size * 4
    assert triangles.max() == len(positions) - 1


# ---------------------------------------------------------------------------------------------------------- measuring


def run(wall_ms: float) -> dict[str, float]:
    return {"wall_ms": wall_ms, "cpu_ms": 2 * wall_ms, "spent_ms": wall_ms}


def test_a_point_is_measured_until_its_median_settles_or_its_time_is_spent() -> None:
    limits = Limits(point_s=1.0, min_runs=5, max_runs=8)
    point = Point("cycles", "cycles", "1 samples")
    errors = {"irradiance": {"rmse": 0.1}}
    assert not Measured(point).enough(limits)
    assert not Measured(point, [run(10)] * 4, errors).enough(limits)
    assert Measured(point, [run(10)] * 5, errors).enough(limits)
    assert not Measured(point, [run(10), run(20), run(30), run(40), run(50)], errors).enough(limits)
    assert Measured(point, [run(n) for n in range(10, 18)], errors).enough(limits)
    assert Measured(point, [run(1200)], errors).enough(limits)
    assert Measured(point, failure="broken").enough(limits)


def test_what_was_measured_is_found_again(tmp_path: Path) -> None:
    point = Point("ours", "masked_rays", "rays 16", {"technique": "masked_rays", "settings": {"rays": 16}})
    store = Store(tmp_path)
    assert store.load(point).runs == []
    store.save(Measured(point, [run(1.5)], {"area": {"rmse": 0.25}}))
    again = Store(tmp_path).load(point)
    assert again.runs == [run(1.5)] and again.errors["area"]["rmse"] == 0.25
    assert not list(tmp_path.glob("*.partial"))


def test_each_picture_is_held_against_the_truth_of_its_question(tmp_path: Path) -> None:
    pytest.importorskip("penumbra_core")
    ones, zeros = np.ones((4, 5), np.float32), np.zeros((4, 5), np.float32)
    truth = {"mask": np.ones((4, 5), np.uint8), "area": 0.5 * ones, "irradiance": 0.25 * ones, "filtered": zeros}
    truth |= {f"{question}_error": zeros for question in ("area", "irradiance", "filtered")}
    np.save(tmp_path / "one.npy", ones)
    np.stack([0.25 * ones, ones]).tofile(tmp_path / "two.bin")
    found = {
        worker: {question: errors["rmse"] for question, errors in measuring.errors_of(worker, file, truth).items()}
        for worker, file in (("cycles", tmp_path / "one.npy"), ("ours", tmp_path / "one.npy"))
    }
    assert found == {"cycles": {"filtered": 1.0}, "ours": {"area": 0.5, "irradiance": 0.75}}
    embree = measuring.errors_of("embree", tmp_path / "two.bin", truth)
    assert (embree["irradiance"]["rmse"], embree["area"]["rmse"]) == (0.0, 0.5)


def test_only_the_same_knobs_turned_further_are_dearer() -> None:
    assert measuring.no_dearer({"rays": 16}, {"rays": 64})
    assert not measuring.no_dearer({"rays": 64}, {"rays": 16})
    assert not measuring.no_dearer({}, {"rays": 16})
    assert not measuring.no_dearer({"map_size": 256}, {"rays": 512})
    assert not measuring.no_dearer({"filter": "2x2"}, {"filter": "bicubic16"})


def test_every_curve_has_points_with_ids_of_their_own() -> None:
    for sweep in plan.LIMITS:
        ids = [point.id for curve in plan.CURVES for point in curve.points(sweep)]
        assert len(ids) == len(set(ids)) > len(plan.CURVES)


# --------------------------------------------------------------------------------------------------------------- page


def kept(folder: Path, curve: str, worker: str, points: dict[str, tuple[float, float, float]]) -> None:
    """Points of a curve: label -> (wall ms, error by area, error by irradiance)."""
    store = Store(folder / "points")
    for label, (wall, area, irradiance) in points.items():
        values = {"area": area, "irradiance": irradiance, "filtered": irradiance}
        errors = {question: {"rmse": values[question]} for question in measuring.QUESTIONS[worker]}
        store.save(Measured(Point(worker, curve, label, {}), [run(wall)], errors))


@pytest.fixture
def measured_folder(tmp_path: Path) -> Path:
    folder = tmp_path / "knot"
    kept(folder, "masked_rays", "ours", {"rays 16": (10, 0.02, 0.03), "rays 64": (40, 0.005, 0.02)})
    kept(folder, "pcf", "ours", {"defaults": (5, 0.06, 0.06)})
    kept(folder, "cycles", "cycles", {"4 samples": (400, 0, 0.02), "16 samples": (1600, 0, 0.005)})
    kept(folder, "embree", "embree", {"4 samples": (20, 0.02, 0.02), "64 samples": (320, 0.00125, 0.00125)})
    facts = {"ours": {"sync_ms": 1.0, "version": "", "environment": {}}, "cycles": {"sync_ms": 2.0, "version": "4.5"}}
    (folder / "facts.json").write_text(json.dumps(facts))
    np.savez(folder / "truth.npz", area=np.zeros(1))
    return tmp_path


SETTINGS = {"sweep": "quick", "size": [512, 512], "reference_error": 0.001}


def test_the_targets_follow_from_the_points(measured_folder: Path) -> None:
    (scene,) = results.collect(measured_folder, ["knot", "never measured"], SETTINGS, "peers.py")["scenes"]
    by_error = {target["error"]: target for target in scene["targets_same"]}
    at = by_error[0.01]
    assert at["wall_ms"]["best_ours"] == "masked_rays" and at["setting"] == "rays 64"
    assert at["times"]["wall_ms"]["masked_rays"] == pytest.approx(20)
    assert at["times"]["wall_ms"]["pcf"] is None
    assert at["wall_ms"]["over_blender"] == pytest.approx(20 / 800)
    assert at["wall_ms"]["over_embree"] == pytest.approx(20 / 40)
    seen = {target["error"]: target for target in scene["targets_seen"]}
    assert seen[0.02]["setting"] == "rays 64" and seen[0.01]["wall_ms"]["over_embree"] is None


def test_the_noise_of_the_truth_is_no_error_of_a_renderer() -> None:
    assert results.own_error({"rmse": 0.005}) == 0.005
    assert results.own_error({"rmse": 0.005, "reference_standard_error": 0.003}) == pytest.approx(0.004)
    assert results.own_error({"rmse": 0.003, "reference_standard_error": 0.004}) == pytest.approx(0.002)


def test_the_page_marks_a_missed_target_and_goes_between_its_marks(measured_folder: Path, tmp_path: Path) -> None:
    report = results.collect(measured_folder, ["knot"], SETTINGS, "peers.py --quick")
    text = page.section(report)
    assert "**0.5 (0.5)**" in text and "0.025 (0.025)" in text
    docs = tmp_path / "docs"
    (docs / "images").mkdir(parents=True)
    (docs / "performance.md").write_text(f"before\n{page.BEGIN}\nold\n{page.END}\nafter\n")
    for _ in range(2):
        page.put_into_docs(report, docs)
    written = (docs / "performance.md").read_text()
    assert written == f"before\n{text}after\n"
    assert (docs / page.PICTURE).read_text().lstrip().startswith("<?xml")
