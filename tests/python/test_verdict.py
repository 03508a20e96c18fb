from __future__ import annotations

import ramps
from penumbra import verdict
from penumbra.records import LightResult, Record


def record(name: str, error: float, ms: float, width: float = 0.01) -> Record:
    made = Record(name, name.upper(), {})
    made.area = {
        "penumbra_rmse": error,
        "rmse": error,
        "penumbra_pixels": 5,
        "pixels": 9,
        "within_reference_noise": False,
    }
    made.time_ms = {"dynamic": ramps.spread(ms, width)}
    return made


def light(*records: Record, target: float | None = None) -> LightResult:
    made = LightResult("Key", "rectangle", [1, 1], records=list(records))
    verdict.judge(made, target, ramps.staircase)
    return made


def test_the_cheapest_within_an_error_wins_its_budget() -> None:
    made = light(record("a", 0.3, 1), record("b", 0.04, 5), record("c", 0.015, 9), record("d", 0.012, 30))
    assert [budget.technique for budget in made.budgets] == ["b", "b", "c", None, None]


def test_an_error_equal_to_the_budget_is_within_it() -> None:
    assert light(record("a", 0.05, 1)).budgets[1].technique == "a"


def test_overlapping_intervals_are_a_tie_and_said_so() -> None:
    made = light(record("a", 0.04, 5.0, 0.05), record("b", 0.03, 5.2, 0.05), record("c", 0.03, 9.0), target=0.05)
    assert made.budgets[0].technique == "a"
    assert [made.records[i].technique for i in made.budgets[0].ties] == ["b"]
    assert any("B cannot be told from it by time" in sentence for sentence in made.sentences)


def test_a_target_nobody_reaches_is_null_and_said_so() -> None:
    made = light(record("a", 0.3, 1), target=0.1)
    assert made.cheapest_within_target is None
    assert "No technique stays within the target of 0.1." in made.sentences


def test_without_a_penumbra_the_error_over_the_mask_decides() -> None:
    a, b = record("a", 0.0, 1), record("b", 0.0, 2)
    for item, rmse in ((a, 0.2), (b, 0.001)):
        assert item.area is not None
        item.area.update(penumbra_pixels=0, rmse=rmse)
    made = light(a, b)
    assert made.budgets[0].technique == "b"
    assert made.sentences[0].startswith("No visible pixel is partly lit")


def test_failed_records_are_neither_on_the_front_nor_in_a_sentence() -> None:
    failed = Record("a", "A", {}, status="failed", reason="out of memory")
    made = light(failed, record("b", 0.1, 2))
    assert not failed.on_pareto_front
    assert made.records[1].on_pareto_front
    assert all("A" not in sentence.split() for sentence in made.sentences)


def test_a_light_without_any_record_says_so() -> None:
    assert light().sentences == ["No technique could be measured at this light."]


def step(name: str, error: float, ms: float, value: int, width: float = 0.01) -> Record:
    made = record(name, error, ms, width)
    made.sweep = {"setting": "rays", "value": value, "changed": {"rays": value}}
    made.settings, made.given = {"rays": value}, {"rays": value}
    return made


def test_the_pick_says_what_it_saves_and_how_to_ask_for_it() -> None:
    made = light(record("a", 0.01, 100.0), step("a", 0.04, 25.0, 4), record("b", 0.02, 50.0), target=0.05)
    pick = made.pick
    assert pick is not None
    assert (pick.technique, pick.record) == ("a", 1)
    assert pick.arguments == ["--techniques", "a", "--set", "a.rays=4"]
    assert [(s.against, s.record, round(s.share, 9)) for s in pick.savings] == [
        ("default", 0, 0.75),
        ("next_best", 2, 0.5),
    ]
    # Ends of the ratio of two intervals, each one per cent wide on either side.
    assert pick.savings[1].low == 1 - 25.25 / 49.5 and pick.savings[1].high == 1 - 24.75 / 50.5
    assert pick.sentence in made.sentences
    assert "it saves 75 % (74 to 75 %) of the time of its default settings and 50 %" in pick.sentence
    assert "of that of the next best technique, B" in pick.sentence


def test_a_pick_whose_default_misses_the_target_says_so() -> None:
    made = light(record("a", 0.3, 1.0), step("a", 0.04, 25.0, 4), target=0.05)
    assert made.pick is not None
    assert [s.against for s in made.pick.savings] == []
    assert "with its default settings it misses the target (error 0.3)" in made.pick.sentence
    assert "no other technique stays within it" in made.pick.sentence


def test_a_saving_that_the_timing_cannot_tell_is_not_claimed() -> None:
    made = light(record("a", 0.04, 5.0, 0.1), record("b", 0.04, 5.3, 0.1), target=0.05)
    assert made.pick is not None
    assert "saves" not in made.pick.sentence
    assert "B cannot be told from it by time" in made.pick.sentence


def test_a_saving_from_few_runs_is_told_as_about() -> None:
    a, b = record("a", 0.04, 5.0, 0.0), record("b", 0.04, 10.0, 0.0)
    b.time_ms["dynamic"].runs = 1
    made = light(a, b, target=0.05)
    assert made.pick is not None
    assert "it saves about 50 % of the time of the next best technique, B" in made.pick.sentence


def test_many_settings_within_the_references_noise_are_counted_and_not_listed() -> None:
    made = light(record("b", 0.3, 1.0), *(step("a", 0.01, 5.0 + n, n) for n in (4, 8, 16)))
    for item in made.records:
        assert item.area is not None
        item.area["within_reference_noise"] = True
    told = verdict.sentences(made, None)
    assert any(said.startswith("B, A (3 settings) differ from the reference") for said in told)


def test_without_a_target_or_with_one_that_nobody_reaches_nothing_is_picked() -> None:
    assert light(record("a", 0.3, 1.0)).pick is None
    assert light(record("a", 0.3, 1.0), target=0.1).pick is None


def test_a_techniques_own_front_is_marked_beside_that_of_all() -> None:
    made = light(record("a", 0.1, 1.0), record("b", 0.2, 2.0), step("b", 0.15, 3.0, 4), step("b", 0.3, 4.0, 9))
    assert [r.on_pareto_front for r in made.records] == [True, False, False, False]
    assert [r.on_own_front for r in made.records] == [True, True, True, False]


def test_it_is_said_whether_every_median_is_known_as_well_as_asked_for() -> None:
    made = light(record("a", 0.1, 10.0), record("b", 0.2, 2.0, 0.2))
    assert verdict.timing_sentence(made) == ""  # nothing is told
    for item in made.records:
        item.time_ms["dynamic"].tight = True
    assert verdict.timing_sentence(made) == "All 2 medians of frame times are known to 5 %."
    made.records[1].time_ms["dynamic"].tight = False
    said = verdict.timing_sentence(made)
    assert said.startswith("1 of 2 medians of frame times are not known to 5 %")
    assert "is 40 % of its median (B, dynamic frame, 12 runs)" in said
    assert verdict.medians(made) == (2, 1)


def test_times_are_shown_with_three_digits() -> None:
    shown = [verdict.milliseconds(value) for value in (0.04312, 4.312, 43.12, 431.2, 4312.0)]
    assert shown == ["0.0431 ms", "4.31 ms", "43.1 ms", "431 ms", "4.31 s"]
