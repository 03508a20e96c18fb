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


def test_times_are_shown_with_three_digits() -> None:
    shown = [verdict.milliseconds(value) for value in (0.04312, 4.312, 43.12, 431.2, 4312.0)]
    assert shown == ["0.0431 ms", "4.31 ms", "43.1 ms", "431 ms", "4.31 s"]
