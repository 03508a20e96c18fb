"""Several lights as one, and several scenes. Every time here is made up."""

from __future__ import annotations

import math
from typing import Any

import pytest
import ramps
from penumbra import together, verdict
from penumbra.records import Comparison, LightResult, Record, SceneResult, Spread


def record(name: str, error: float, ms: float, rays: int, base: bool = True, width: float = 0.0) -> Record:
    made = Record(name, name.upper(), {"rays": rays})
    made.given = {} if base else {"rays": rays}
    made.sweep = None if base else {"setting": "rays", "value": rays, "changed": {"rays": rays}}
    made.area = {"penumbra_rmse": error, "rmse": error, "penumbra_pixels": 5, "pixels": 9, "leak": 0.0}
    made.irradiance = dict(made.area)
    made.time_ms = {"dynamic": Spread(ms, ms, ms, ms * (1 - width), ms * (1 + width), 9, True)}
    return made


def light(name: str, *records: Record) -> LightResult:
    made = LightResult(name, "rectangle", [1, 1], records=list(records))
    verdict.judge(made, None, ramps.staircase)
    return made


def scene(name: str, *lights: LightResult) -> SceneResult:
    return SceneResult(f"{name}.blend", "Camera", 1, (8, 6), 2, lights=list(lights))


def test_lights_of_a_scene_add_their_times_and_the_largest_error_counts() -> None:
    made = together.combine(
        [light("a", record("x", 0.1, 3.0, 4)), light("b", record("x", 0.3, 4.0, 4))], "all", together.added
    )
    (found,) = made.records
    assert found.headline == 0.3
    assert found.time_ms["dynamic"].median == 7.0


def test_intervals_of_added_times_add_as_squares() -> None:
    a, b = Spread(10.0, 9, 11, 7.0, 13.0, 9, True), Spread(20.0, 19, 21, 16.0, 24.0, 5, False)
    found = together.added([a, b])
    assert (found.low, found.median, found.high) == pytest.approx((25.0, 30.0, 35.0))
    assert (found.runs, found.tight) == (5, False)


def test_a_geometric_mean_and_its_interval_are_those_of_the_logarithms() -> None:
    a, b = Spread(1.0, 1, 1, 0.5, 2.0, 9, True), Spread(100.0, 100, 100, 100.0, 100.0, 9, None)
    found = together.geometric_mean([a, b])
    assert found.median == pytest.approx(10.0)
    assert found.high / found.median == pytest.approx(math.sqrt(2.0))
    assert found.median / found.low == pytest.approx(math.sqrt(2.0))
    assert found.tight is None


def test_only_settings_that_were_measured_at_every_light_count() -> None:
    a = light("a", record("x", 0.1, 3.0, 4), record("x", 0.05, 9.0, 16, base=False), record("y", 0.2, 1.0, 4))
    b = light("b", record("x", 0.2, 3.0, 4), record("x", 0.06, 9.0, 64, base=False))
    comparison = Comparison({}, scenes=[scene("s", a, b)])
    together.summarise(comparison, None)
    whole = comparison.scenes[0].together
    assert whole is not None
    assert [(r.technique, r.settings) for r in whole.records] == [("x", {"rays": 4})]
    assert whole.sentences[-1] == "Not measured everywhere, and so not here: Y."


def test_one_light_and_one_scene_have_nothing_to_put_together() -> None:
    comparison = Comparison({}, scenes=[scene("s", light("a", record("x", 0.1, 3.0, 4)))])
    together.summarise(comparison, 0.2)
    assert comparison.scenes[0].together is None
    assert comparison.together is None and comparison.targets == []


def test_a_light_at_which_nothing_could_be_measured_does_not_empty_the_rest() -> None:
    broken = LightResult("broken", "sun", [], records=[Record("x", "X", {}, "failed", "no reference")])
    a, b = light("a", record("x", 0.1, 3.0, 4)), light("b", record("x", 0.2, 3.0, 4))
    comparison = Comparison({}, scenes=[scene("s", a, broken, b)])
    together.summarise(comparison, None)
    whole = comparison.scenes[0].together
    assert whole is not None and len(whole.records) == 1


def compared(target: float | None = 0.15) -> Comparison:
    """Two scenes: of one light, and of two; ray tracing in three steps, and a fast wrong technique."""

    def one(name: str, factor: float) -> LightResult:
        return light(
            name,
            record("rays", 0.4, 1.0 * factor, 1),
            record("rays", 0.2, 4.0 * factor, 4, base=False),
            record("rays", 0.1, 16.0 * factor, 16, base=False),
            record("map", 0.3, 0.5, 1),
        )

    comparison = Comparison({}, scenes=[scene("s", one("a", 1.0)), scene("t", one("b", 10.0), one("c", 6.0))])
    together.summarise(comparison, target)
    return comparison


def test_a_set_of_scenes_has_geometric_mean_times_its_own_front_and_a_pick() -> None:
    whole = compared().together
    assert whole is not None
    by_rays = {r.settings["rays"]: r for r in whole.records if r.technique == "rays"}
    assert by_rays[4].time_ms["dynamic"].median == pytest.approx(math.sqrt(4.0 * 64.0))
    assert [r.technique for r in whole.records if r.on_pareto_front] == ["rays", "rays", "map"]
    assert whole.pick is not None and whole.records[whole.pick.record].settings == {"rays": 16}
    assert whole.pick.arguments == ["--techniques", "rays", "--set", "rays.rays=16"]


def test_targets_over_the_set_are_ratios_to_each_scenes_fastest() -> None:
    comparison = compared()
    coarse = next(target for target in comparison.targets if target.error == 0.15)
    assert coarse.winner == "rays"
    ratios: dict[str, Any] = {mean.technique: (mean.scenes, mean.ratio) for mean in coarse.means}
    assert ratios == {"rays": (2, pytest.approx(1.0)), "map": (0, None)}
