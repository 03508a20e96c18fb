"""What is kept as JSON comes back as it was."""

from __future__ import annotations

import json
import math

from penumbra.records import (
    Budget,
    Comparison,
    Failure,
    LightResult,
    Pick,
    Reach,
    Record,
    Saving,
    SceneResult,
    Spread,
    Statistic,
    Step,
    Target,
    from_json,
    to_json,
)


def comparison() -> Comparison:
    errors = {"penumbra_rmse": 0.1, "penumbra_pixels": 3, "rmse": 0.02, "parts": {"noise": 0.0}, "dominant": "bias"}
    errors |= {"sentence": "Bias dominates."}
    record = Record("pcf", "Filtering", {"kernel": 5}, seeds=2, area=errors, irradiance=dict(errors), flip=None)
    record.time_ms = {
        "dynamic": Spread(1.0, 0.9, 1.1, 0.95, 1.05, 9, True),
        "setup": Spread(1.0, 0.9, 1.1, 0.95, 1.05, 1),
    }
    record.memory_bytes, record.on_pareto_front = 123, True
    record.plan = [Step("map", "run", time_ms=0.5), Step("mask", "left_out", "none is needed", "rule", 0.1)]
    record.statistics = [Statistic("rays", "Rays", "", 12.0)]
    step = Record("pcf", "Filtering", {"kernel": 9}, "failed", "it broke", sweep={"setting": "kernel", "value": 9})
    light = LightResult("Key", "rectangle", [1.0, 2.0], {"pixels": 9}, None, {"method": "rays"}, [record, step])
    record.headline_error, record.on_own_front, record.given = 0.001, True, {"kernel": 5}
    light.targets = [
        Target(0.05, "pcf", ["a"], [Reach("pcf", "Filtering", "reached", 1.0, 0.9, 1.1, [0, 1], 1, {"n": 2}, 0.1)])
    ]
    light.pick = Pick(0.05, "pcf", 0, ["--set", "pcf.n=2"], [Saving("next_best", "a", 1, 0.5, 0.4, 0.6)], "It saves.")
    light.budgets, light.sentences, light.angle_rad = [Budget(0.1, "pcf", 0, [1])], ["So it is."], 0.5
    scene = SceneResult("a.blend", "Camera", 3, (8, 6), 12, {"lights": 1}, ["a note"], [light])
    return Comparison({"cpu": "x"}, {"sweep": "off"}, [scene], [Failure("Key, pcf", "it broke")])


def test_records_come_back_from_json_as_they_were() -> None:
    kept = comparison()
    assert from_json(json.loads(json.dumps(to_json(kept), allow_nan=False))) == kept


def test_what_was_not_a_number_is_none_again() -> None:
    kept = comparison()
    record = kept.scenes[0].lights[0].records[0]
    assert record.area is not None
    record.area["penumbra_width_ratio"] = math.nan
    found = from_json(json.loads(json.dumps(to_json(kept), allow_nan=False))).scenes[0].lights[0].records[0]
    assert found.area is not None and math.isnan(found.area["penumbra_width_ratio"])


def test_a_report_from_before_targets_were_known_is_read() -> None:
    document = json.loads(json.dumps(to_json(comparison())))
    for name in ("together", "targets"):
        document.pop(name)
        document["scenes"][0].pop(name, None)
    light = document["scenes"][0]["lights"][0]
    light.pop("targets"), light.pop("pick")
    for record in light["records"]:
        for name in ("given", "headline", "headline_error", "on_own_front"):
            record.pop(name, None)
        for spread in record.get("time_ms", {}).values():
            spread.pop("tight")
    found = from_json(document).scenes[0].lights[0]
    assert found.targets == [] and found.pick is None
    assert found.records[0].time_ms["dynamic"].tight is None
    assert found.records[1].changed == {"kernel": 9}
