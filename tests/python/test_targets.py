"""When a technique reaches an error: closed forms on curves that are power laws. Every time here is made up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from penumbra import targets
from penumbra.records import LightResult, Record, Spread
from penumbra.targets import Point, interpolated


def record(
    name: str, error: float, ms: float, settings: dict | None = None, width: float = 0.0, se: float = 0.0
) -> Record:
    made = Record(name, name.upper(), dict(settings or {}))
    made.area = {"penumbra_rmse": error, "rmse": error, "penumbra_pixels": 5, "pixels": 9}
    made.headline_error = se
    made.time_ms = {"dynamic": Spread(ms, ms, ms, ms * (1 - width), ms * (1 + width), 9)}
    return made


def light(*records: Record) -> LightResult:
    return LightResult("Key", "rectangle", [1, 1], records=list(records))


def power_law(name: str = "rays", factor: float = 1.0) -> list[Record]:
    """error = n^-1/2, time = factor n: the time to the error e is factor / e^2."""
    return [record(name, n**-0.5, factor * n, {"rays": n, "seed": 1}) for n in (4, 64, 1024, 16384)]


@pytest.mark.parametrize("error", [0.4, 0.125, 0.05, 0.02, 0.01])
def test_on_a_power_law_the_time_between_two_steps_is_exact(error: float) -> None:
    found = targets.reach(light(*power_law()), "rays", error)
    assert found.state == "reached"
    assert found.time_ms == pytest.approx(1 / error**2, rel=1e-12)


def test_the_setting_between_two_steps_is_the_knobs_value_there_and_rather_too_good() -> None:
    found = targets.reach(light(*power_law()), "rays", 0.0501)
    assert found.about == {"rays": math.ceil(1 / 0.0501**2)}
    assert found.record == 2 and found.between == [1, 2]  # 1024 rays are within it for sure


def test_a_target_that_a_step_meets_exactly_takes_that_steps_time() -> None:
    found = targets.reach(light(*power_law()), "rays", 1 / 8)
    assert (found.time_ms, found.record) == (pytest.approx(64.0), 1)


def test_the_fastest_step_within_the_target_gives_a_bound_and_says_so() -> None:
    found = targets.reach(light(*power_law()), "rays", 0.6)
    assert (found.state, found.time_ms, found.record, found.between) == ("at_most", 4.0, 0, [0])


def test_a_target_below_every_error_is_not_reached_and_the_smallest_error_is_told() -> None:
    found = targets.reach(light(*power_law()), "rays", 0.001)
    assert (found.state, found.time_ms, found.record) == ("not_reached", None, None)
    assert found.closest == pytest.approx(1 / 128)


def test_settings_that_cost_more_and_are_no_better_are_not_on_the_curve() -> None:
    worse = record("rays", 0.3, 500.0, {"rays": 64, "seed": 9})
    assert targets.curve(light(worse, *power_law()), "rays") == [1, 2, 3, 4]
    assert targets.reach(light(worse, *power_law()), "rays", 0.05).time_ms == pytest.approx(400.0)


def test_nothing_is_interpolated_between_two_kinds_of_filter() -> None:
    made = light(record("pcf", 0.2, 1.0, {"filter": "2x2"}), record("pcf", 0.05, 4.0, {"filter": "box"}))
    found = targets.reach(made, "pcf", 0.1)
    assert (found.state, found.time_ms, found.between, found.about) == ("reached", 4.0, [1], {})


def test_nothing_is_interpolated_towards_an_error_of_zero() -> None:
    made = light(record("a", 0.2, 1.0, {"n": 1}), record("a", 0.0, 4.0, {"n": 2}))
    assert targets.reach(made, "a", 0.1).time_ms == 4.0


def test_of_a_ladders_step_no_single_setting_is_named() -> None:
    made = light(record("a", 0.2, 1.0, {"n": 1, "m": 4}), record("a", 0.05, 4.0, {"n": 2, "m": 8}))
    found = targets.reach(made, "a", 0.1)
    assert found.time_ms == pytest.approx(2.0)
    assert found.about == {}


def test_the_interval_of_a_step_itself_is_that_of_its_median() -> None:
    a, b = Point(1.0, 0.9, 1.2, 0.4), Point(8.0, 7.0, 10.0, 0.1)
    assert interpolated(a, b, 0.1) == pytest.approx((8.0, 7.0, 10.0))


def test_uncertain_times_add_as_squares_of_logarithms() -> None:
    a, b = Point(1.0, 1 / 1.1, 1.1, 0.4), Point(16.0, 16 / 1.3, 16 * 1.3, 0.1)
    time, low, high = interpolated(a, b, 0.2)  # half way
    assert time == pytest.approx(4.0)
    half = math.hypot(0.5 * math.log(1.1), 0.5 * math.log(1.3))
    assert math.log(high / time) == pytest.approx(half)
    assert math.log(time / low) == pytest.approx(half)


def test_the_interval_covers_what_random_measurements_scatter() -> None:
    generator = np.random.default_rng(5)
    times, errors, time_se, error_se = (2.0, 20.0), (0.06, 0.02), (0.03, 0.02), (0.02, 0.03)
    scatter = []
    for _ in range(4000):
        t = [m * math.exp(s * generator.standard_normal()) for m, s in zip(times, time_se, strict=True)]
        e = [m * math.exp(s * generator.standard_normal()) for m, s in zip(errors, error_se, strict=True)]
        scatter.append(math.log(interpolated(Point(t[0], t[0], t[0], e[0]), Point(t[1], t[1], t[1], e[1]), 0.04)[0]))
    ends = [(t * math.exp(-1.96 * s), t * math.exp(1.96 * s)) for t, s in zip(times, time_se, strict=True)]
    a = Point(times[0], *ends[0], errors[0], errors[0] * error_se[0])
    b = Point(times[1], *ends[1], errors[1], errors[1] * error_se[1])
    _, low, high = interpolated(a, b, 0.04)
    assert math.log(high / low) == pytest.approx(2 * 1.96 * np.std(scatter), rel=0.05)


def test_the_winner_is_the_first_to_reach_it_and_who_cannot_be_told_from_it_is_a_tie() -> None:
    made = light(
        record("a", 0.3, 1.0),
        record("a", 0.04, 9.0, width=0.1),
        record("b", 0.03, 7.2, width=0.1),
        record("c", 0.01, 40.0),
    )
    found = targets.target(made, 0.05)
    assert found.winner == "a" and found.ties == ["b"]
    assert [each.state for each in found.reaches] == ["reached", "at_most", "at_most"]


def test_a_target_that_nobody_reaches_has_no_winner() -> None:
    found = targets.target(light(record("a", 0.3, 1.0)), 0.05)
    assert (found.winner, found.ties) == (None, [])
    assert [each.state for each in found.reaches] == ["not_reached"]


def test_the_ratio_over_scenes_is_the_geometric_mean_and_no_scene_weighs_more_for_being_slow() -> None:
    scenes = [
        [targets.target(light(*power_law("a", 1.0), *power_law("b", 2.0)), 0.05)],
        [targets.target(light(*power_law("a", 8000.0), *power_law("b", 1000.0)), 0.05)],
    ]
    (found,) = targets.over_scenes(scenes)
    by_name = {mean.technique: mean for mean in found.means}
    assert by_name["a"].ratio == pytest.approx(math.sqrt(1 * 8))
    assert by_name["b"].ratio == pytest.approx(math.sqrt(2 * 1))
    assert (found.winner, found.scenes) == ("b", 2)


def test_who_reaches_it_in_more_scenes_stands_before_who_is_faster_in_one() -> None:
    both = light(*power_law("fast", 1.0), *power_law("sure", 50.0))
    one = light(record("fast", 0.3, 1.0), *power_law("sure", 50.0))
    (found,) = targets.over_scenes([[targets.target(both, 0.05)], [targets.target(one, 0.05)]])
    assert found.winner == "sure"
    assert [(mean.technique, mean.scenes) for mean in found.means] == [("sure", 2), ("fast", 1)]


def test_a_scene_in_which_nobody_reaches_it_counts_for_nobody() -> None:
    nobody = light(record("a", 0.3, 1.0))
    (found,) = targets.over_scenes([[targets.target(nobody, 0.05)], [targets.target(nobody, 0.05)]])
    assert found.winner is None
    assert [(mean.scenes, mean.ratio) for mean in found.means] == [(0, None)]


def test_the_users_target_joins_those_of_every_report() -> None:
    assert targets.errors_asked(None) == [0.05, 0.02, 0.01, 0.005]
    assert targets.errors_asked(0.03) == [0.05, 0.03, 0.02, 0.01, 0.005]
    assert targets.errors_asked(0.02) == [0.05, 0.02, 0.01, 0.005]
