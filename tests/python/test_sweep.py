"""Which settings a sweep tries."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest
from penumbra import sweep
from penumbra.records import Record


def setting(name: str, default: Any, values: list[Any], **more: Any) -> dict[str, Any]:
    kind = {bool: "bool", int: "int", float: "float", str: "choice"}[type(default)]
    return {"id": name, "type": kind, "default": default, "sweep": values} | more


def technique(knob: str, *settings: dict[str, Any]) -> dict[str, Any]:
    return {"id": "t", "knob": knob, "settings": list(settings)}


MAP = setting("map_size", 1024, [256, 512, 1024, 2048, 4096])
SAMPLES = setting("samples", 16, [4, 16, 64, 256])
SIDES = setting("sides", "outer", ["outer", "both"])


def test_without_a_sweep_there_is_no_step() -> None:
    assert sweep.steps(technique("samples", MAP, SAMPLES), {}, "off") == []


def test_a_quick_sweep_turns_the_knob_to_three_values_and_never_the_dearest() -> None:
    info = technique("rays", setting("rays", 16, [1, 4, 16, 64, 256, 1024]), MAP)
    assert sweep.steps(info, {}, "quick") == [{"rays": 1}, {"rays": 64}]  # the middle of the three stands
    assert sweep.steps(info, {"rays": 9}, "quick") == [{"rays": 1}, {"rays": 4}, {"rays": 16}]
    assert sweep.steps(info, {"rays": 5000}, "quick") == [{"rays": 1}, {"rays": 16}, {"rays": 256}]
    assert sweep.steps(info, {"rays": 1}, "quick") == [{"rays": 4}, {"rays": 16}]


def test_a_quick_sweep_tries_the_other_choices_too() -> None:
    info = technique("map_size", MAP, SIDES)
    assert sweep.steps(info, {}, "quick") == [{"map_size": 256}, {"map_size": 2048}, {"sides": "both"}]


def test_a_full_sweep_tries_every_value_alone_and_then_all_knobs_rising_together() -> None:
    steps = sweep.steps(technique("samples", MAP, SAMPLES), {}, "full")
    assert steps == [
        {"map_size": 256}, {"map_size": 512}, {"map_size": 2048}, {"map_size": 4096},
        {"samples": 4}, {"samples": 64}, {"samples": 256},
        {"map_size": 256, "samples": 4}, {"map_size": 2048, "samples": 64},
    ]  # fmt: skip


def test_the_dearest_values_are_never_joined() -> None:
    for step in sweep.steps(technique("samples", MAP, SAMPLES), {"map_size": 64, "samples": 2}, "full"):
        assert step not in ({"map_size": 4096, "samples": 256},)


def test_a_full_sweep_grows_with_the_sum_of_its_lists() -> None:
    knobs = [setting(f"k{i}", 0, list(range(1, 9))) for i in range(5)]
    assert len(sweep.steps(technique("k0", *knobs), {}, "full")) == 5 * 8 + 7


def test_a_choice_climbs_the_ladder_with_the_numbers() -> None:
    joint = [step for step in sweep.steps(technique("map_size", MAP, SIDES), {}, "full") if len(step) > 1]
    assert joint == [{"map_size": 2048, "sides": "both"}]


def test_a_choice_of_another_kind_stays_off_the_ladder() -> None:
    kind = setting("filter", "box", ["2x2", "bicubic"])
    steps = sweep.steps(technique("samples", MAP, SAMPLES, kind), {}, "full")
    assert {"filter": "2x2"} in steps
    assert all("filter" not in step for step in steps if len(step) > 1)


def test_a_knob_that_changes_nothing_as_things_stand_is_not_turned() -> None:
    facets = setting("facets", 24, [6, 24, 48], sweep_when={"mode": "literal"})
    info = technique("facets", setting("mode", "exact", []), facets)
    assert sweep.steps(info, {}, "full") == []
    assert sweep.steps(info, {"mode": "literal"}, "full") == [{"facets": 6}, {"facets": 48}]


def test_a_step_is_named_by_all_that_it_changes() -> None:
    assert sweep.entry({"rays": 4}) == {"setting": "rays", "value": 4, "changed": {"rays": 4}}
    joint = sweep.entry({"map_size": 256, "mask": True})
    assert Record("t", "T", {}, sweep=joint).label() == "T (map_size 256, mask on)"
    assert Record("t", "T", {}, sweep={"setting": "rays", "value": 4}).changed == {"rays": 4}  # of an older file


@pytest.fixture(scope="module")
def infos(core: Any) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = core.techniques()
    return found


def test_every_technique_says_which_knob_it_has(infos: list[dict[str, Any]]) -> None:
    for info in infos:
        numbers = [s["id"] for s in info["settings"] if s["sweep"] and s["type"] in ("int", "float")]
        assert info["knob"] in numbers if numbers else info["knob"] == "", info["id"]


def test_every_value_of_every_sweep_is_one_that_the_setting_takes(infos: list[dict[str, Any]]) -> None:
    for info in infos:
        by_id = {s["id"]: s for s in info["settings"]}
        for s in info["settings"]:
            where = f"{info['id']}.{s['id']}"
            assert len(set(s["sweep"])) == len(s["sweep"]), where
            if s["type"] == "choice":
                assert set(s["sweep"]) <= set(s["choices"]), where
            else:
                # From cheap to good, which is downwards for masked_rays.share.
                assert s["sweep"] in (sorted(s["sweep"]), sorted(s["sweep"], reverse=True)), where
                assert all(s["minimum"] <= value <= s["maximum"] for value in s["sweep"]), where
            for other, value in s["sweep_when"].items():
                assert value in by_id[other]["choices"], where


def test_map_sizes_samples_filters_and_subdivisions_are_swept_wherever_there_are_any(
    infos: list[dict[str, Any]],
) -> None:
    wanted = {"map_size", "size", "samples", "rays", "kernel", "lines", "sides", "facets", "sheet_parts", "cells"}
    for info in infos:
        for s in info["settings"]:
            # The map of plateaus serves what is on no plane alone.
            if s["id"] in wanted and (info["id"], s["id"]) != ("plateaus", "map_size"):
                assert s["sweep"], f"{info['id']}.{s['id']}"
    swept = Counter(s["id"] for info in infos for s in info["settings"] if s["sweep"])
    assert swept["map_size"] >= 7 and swept["filter"] >= 1


@pytest.mark.parametrize("mode", ["quick", "full"])
def test_no_technique_is_swept_without_end(infos: list[dict[str, Any]], mode: str) -> None:
    most = {"quick": 5, "full": 21}[mode]  # masked_rays has most: ten numbers of rays and a ladder over three knobs
    for info in infos:
        steps = sweep.steps(info, {}, mode)
        assert len(steps) <= most, info["id"]
        assert len({tuple(sorted(step.items())) for step in steps}) == len(steps)
        defaults = {s["id"]: s["default"] for s in info["settings"]}
        assert all(defaults[name] != value for step in steps for name, value in step.items())
