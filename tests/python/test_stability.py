"""`penumbra stability`: its properties on made-up images, its judgement, its processes, and a few cases for real."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import stability_trouble
from penumbra.stability import (
    border,
    closed_forms,
    document,
    ground,
    lamps,
    limits,
    properties,
    rows,
    run,
    scenes,
    setups,
    shapes,
)
from penumbra.stability.bench import MEASURES, SWEEPS
from penumbra.stability.cases import CASES, EVERY_PICTURE, QUICK
from penumbra.stability.closed_forms import FORMS
from penumbra.stability.rows import Measured, Row

Run = Callable[..., subprocess.CompletedProcess[str]]


def image(*values: float) -> properties.Image:
    return np.array([values], np.float32)


def whole(pictured: properties.Image) -> properties.Mask:
    return np.ones(pictured.shape, np.uint8)


RAMP = np.tile(np.clip((np.arange(40, dtype=np.float32) - 10) / 20, 0, 1), (8, 1))
"""Umbra, a ramp of 20 pixels, light."""


# --- properties ------------------------------------------------------------------------------------------------------


def test_finite_counts_what_is_no_number() -> None:
    assert properties.not_finite([RAMP, image(0.0, 1.0)]) == 0
    assert properties.not_finite([image(0.0, math.nan), image(math.inf, -math.inf)]) == 3


def test_range_tells_how_far_outside() -> None:
    assert properties.out_of_range([RAMP]) == 0
    assert properties.out_of_range([image(-0.25, 0.5), image(1.125)]) == 0.25
    assert properties.out_of_range([image(0.5, math.nan)]) == math.inf


def test_differences_count_the_mask_alone() -> None:
    a, b = image(0.0, 0.0, 0.0, 0.0), image(0.0, 0.5, 0.5, 9.0)
    mask = np.array([[1, 1, 0, 0]], np.uint8)
    assert properties.rms_difference(a, b, mask) == pytest.approx(0.5 / math.sqrt(2))
    assert properties.share_changed(a, b, mask) == 0.5
    assert properties.share_changed(a, a + 0.01, mask) == 0
    assert properties.share_changed(a, image(math.nan, 0.0, 0.0, 0.0), mask) == 0.5
    assert properties.rms_difference(a, b, np.zeros_like(mask)) == 0
    assert properties.mask_changed(mask, whole(a)) == 0.5


def test_a_hard_shadow_of_a_ramp_errs_by_one_over_root_twelve() -> None:
    hard = (RAMP > 0.5).astype(np.float32)
    assert properties.penumbra_error(hard, RAMP, whole(RAMP)) == pytest.approx(1 / math.sqrt(12), abs=0.01)
    assert properties.penumbra_error(RAMP, RAMP, whole(RAMP)) == 0
    assert properties.penumbra_error(hard, hard, whole(hard)) == 0, "no penumbra, no error in it"


def test_errors_near_an_edge_are_none_elsewhere() -> None:
    near, far = RAMP.copy(), RAMP.copy()
    near[:, 9] = 1.0
    far[:, 3] = 1.0
    assert properties.wrong_elsewhere(near, RAMP, whole(RAMP)) == 0
    # Away from edges by two pixels: columns 0 .. 8 of the umbra's 0 .. 10, and 32 .. 39 of the light.
    assert properties.wrong_elsewhere(far, RAMP, whole(RAMP)) == pytest.approx(1 / 17)


def test_a_growing_light_may_only_brighten_the_umbra_and_darken_the_light() -> None:
    hard = image(0.0, 0.0, 1.0, 1.0)
    growing = [hard, image(0.0, 0.2, 0.8, 1.0), image(0.1, 0.3, 0.7, 0.9)]
    assert properties.wrong_way(growing, hard, whole(hard)) == 0
    assert properties.wrong_way(growing[::-1], hard, whole(hard)) > 0.1


def test_rates_are_slopes() -> None:
    costs = (4, 16, 64)
    assert properties.rate(costs, [c**-0.75 for c in costs]) == pytest.approx(-0.75)
    assert properties.rate(costs, [0.1, 0.1, 0.1]) == pytest.approx(0.0)
    assert properties.rate(costs, [0.0, 0.0, 0.0]) == -math.inf


def test_pops_are_changes_where_the_truth_stays() -> None:
    moved = np.roll(RAMP, 1, axis=1)
    moved[:, 0] = 0.0
    popped = moved.copy()
    popped[2, 2] = 1.0
    truths = [RAMP, moved]
    assert properties.pops([RAMP, moved], truths, [whole(RAMP)]) == 0
    assert properties.pops([RAMP, popped], truths, [whole(RAMP)]) > 0


def test_even_steps_are_told_from_a_jump() -> None:
    frames = [RAMP + 0.1 * i for i in range(6)]
    assert properties.unevenness(frames, [whole(RAMP)] * 5) == pytest.approx(1.0, abs=0.01)
    jumping = [*frames[:3], *(frame + 0.5 for frame in frames[3:])]
    assert properties.unevenness(jumping, [whole(RAMP)] * 5) == pytest.approx(6.0, abs=0.01)
    flipping = [np.where(np.arange(RAMP.size).reshape(RAMP.shape) < i, 1, 0).astype(np.float32) for i in (0, 0, 1, 1)]
    assert properties.unevenness(flipping, [whole(RAMP)] * 3) == 1.0, "one pixel is no jump"


def test_only_what_stays_in_use_counts_as_grown() -> None:
    held_for_a_frame = [10.0, 10.0, 74.0, 10.0, 10.0, 74.0, 10.0, 74.0, 74.0]
    assert properties.grown(held_for_a_frame) == 0
    assert properties.grown([10.0 + 4.0 * frame for frame in range(24)]) == 32
    assert properties.grown([5.0]) == 0


# --- scenes ----------------------------------------------------------------------------------------------------------


def test_shapes_are_what_they_say() -> None:
    def area(shape: shapes.Shape) -> float:
        a, b, c = (shape[0][shape[1][:, i]].astype(np.float64) for i in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def volume(shape: shapes.Shape) -> float:
        a, b, c = (shape[0][shape[1][:, i]].astype(np.float64) for i in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    plain = shapes.sheet((-1, 1), (-1, 1))
    assert area(plain) == pytest.approx(4)
    assert area(shapes.slivers((-1, 1), (-1, 1), 0.0, 1e6, 8)) == pytest.approx(4, rel=1e-5)
    assert area(shapes.t_junctions((-1, 1), (-1, 1), 0.0, 7)) == pytest.approx(4)
    assert area(shapes.with_degenerates(plain)) == pytest.approx(4)
    assert area(shapes.doubled(plain)) == pytest.approx(10)
    assert volume(shapes.box((0, 0, 0), (1, 2, 3))) == pytest.approx(6)
    assert volume(shapes.inside_out(shapes.box((0, 0, 0), (1, 2, 3)))) == pytest.approx(-6)
    assert volume(shapes.cone(1.0, 3.0, 0.0, 256)) == pytest.approx(math.pi, rel=1e-3)
    assert volume(shapes.ball(1.0, 48)) == pytest.approx(4 / 3 * math.pi, rel=5e-3)
    assert area(shapes.shuffled(shapes.ball(1.0), 3)) == pytest.approx(area(shapes.ball(1.0)))
    assert len(shapes.star(500, 0.7, 1.4, 0.0)[1]) == 500
    assert len(shapes.blades(1000, 1.0, 1.0, 0.1)[1]) == 1000


def test_a_carried_scene_is_the_scene_carried() -> None:
    setup = scenes.yard(0.6, "polygon")
    there = setups.carried(setup, 10.0, setups.odd_turn(), (1.0, 2.0, 3.0))
    points = np.array(setup.lamps[0].corners_ws)
    assert there.lamps[0].corners_ws == pytest.approx(10.0 * points @ setups.odd_turn().T + [1, 2, 3])
    back = setups.carried(
        setups.carried(setups.carried(setup, by=(1.0, 2.0, 3.0)), by=(-1.0, -2.0, -3.0)), turn=np.eye(3)
    )
    assert np.allclose(back.eye.world_from_camera, setup.eye.world_from_camera)
    assert there.eye.near_m == 10.0 * setup.eye.near_m


# --- closed forms ----------------------------------------------------------------------------------------------------


def ground_of(core: Any, setup: setups.Setup) -> ground.Ground:
    renderer = core.Renderer("")

    def truth_of(frame: setups.Setup, exact: bool) -> properties.Image:
        renderer.set_scene(frame.scene(core))
        return np.array(renderer.reference(frame.light, standard_error=0.004, exact=exact)["area"])

    truth = truth_of(setup, True)
    renderer.set_scene(setup.scene(core))
    return ground.Ground(setup, renderer.view(), np.array(renderer.mask(setup.light)), truth, truth_of)


@pytest.fixture(scope="module")
def edge(core: Any) -> ground.Ground:
    """A half-plane's shadow: V is a ramp along x."""
    return ground_of(core, scenes.edge(0.6))


@pytest.mark.usefixtures("working_machine")
def test_a_straight_edge_lies_as_far_from_the_centre_as_the_truth_says(edge: ground.Ground) -> None:
    low, high = edge.distances(("own",))
    outside = edge.centre_seen & (edge.mask != 0)
    distance = np.clip(2.0 * edge.truth[outside] - 1.0, 0.0, 1.0)
    assert outside.sum() > 1000
    assert (low[outside] <= distance + 1e-3).all() and (distance <= high[outside] + 1e-3).all()
    assert (high - low <= 1.0 / ground.LEVELS + 1e-9).all()


@pytest.mark.usefixtures("working_machine")
def test_the_form_of_a_hard_shadow_gives_one_over_root_twelve_on_a_straight_edge(edge: ground.Ground) -> None:
    figure = closed_forms.hard(edge, "shadow_volume").figure("penumbra", edge)
    assert closed_forms.ONE_STEP - 0.01 <= figure <= closed_forms.ONE_STEP + 0.03
    assert closed_forms.hard(edge, "shadow_volume").figure("umbra and light", edge) < 1e-5


@pytest.mark.usefixtures("working_machine")
def test_the_form_of_the_outer_half_is_broken_by_light_in_the_umbra(edge: ground.Ground) -> None:
    allowed = closed_forms.outer(edge, "plateaus")
    inside = np.where(edge.centre_seen, np.clip(2.0 * edge.truth - 1.0, 0.0, 1.0), 0.0).astype(np.float32)
    assert allowed.outside(inside, edge) == 0
    assert allowed.outside(edge.truth, edge) > 0.05, "the inner half is not drawn"
    assert properties.penumbra_error(inside, edge.truth, edge.mask) <= allowed.figure("penumbra", edge)


@pytest.mark.usefixtures("working_machine")
def test_a_form_that_allows_any_picture_says_nothing(edge: ground.Ground) -> None:
    shape = edge.truth.shape
    anything = closed_forms.Allowed(np.zeros(shape), np.ones(shape))
    forms = {"any": anything, "hard": closed_forms.hard(edge, "shadow_volume")}
    bounds, empty = closed_forms.told(forms, "penumbra", edge)
    assert set(bounds) == {"hard"} and empty


@pytest.mark.parametrize(
    ("lamp", "share"),
    [
        (setups.Lamp("point", (0.0, 0.0, 0.0), radius_m=0.5), 0.5),
        (setups.Lamp("point", (0.0, 0.0, 2.0), radius_m=0.5), 1.0),
        (setups.Lamp("rectangle", (1.0, 0.0, 0.25), half_u_ws=(0.0, 1.0, 0.0), half_v_ws=(0.0, 0.0, 0.5)), 0.75),
        (setups.Lamp("sun", direction_ws=(1.0, 0.0, 0.0), sun_angle_rad=0.1), 0.5),
        (setups.Lamp("polygon", corners_ws=((0.0, 0.0, -1.0), (1.0, 0.0, 1.0), (2.0, 0.0, -1.0))), 0.25),
    ],
)
def test_what_of_a_light_lies_over_a_plane(lamp: setups.Lamp, share: float) -> None:
    here, up = np.array([[[-3.0, 0.2, 0.0]]]), np.array([[[0.0, 0.0, 1.0]]])
    assert lamps.above_plane(lamp, here, up)[0, 0] == pytest.approx(share, abs=0.07)


def test_lights_of_other_sizes_keep_their_centre() -> None:
    triangle = scenes.lamp("polygon", 1.0)
    half = lamps.shrunk(triangle, 0.5)
    assert lamps.centre_of(half) == pytest.approx(lamps.centre_of(triangle))
    assert lamps.shrunk(triangle, 0.0).position_ws == pytest.approx(tuple(lamps.centre_of(triangle)))
    sun = lamps.shrunk(scenes.lamp("sun", 1.0), 0.5)
    assert math.tan(0.5 * sun.sun_angle_rad) == pytest.approx(0.5 * 0.5 / scenes.LIGHT_HEIGHT_M)


@pytest.mark.parametrize(("kind", "area"), [("rectangle", 4.0), ("ellipse", math.pi), ("polygon", 2.0)])
def test_a_disc_of_equal_area_holds_its_octagon(kind: str, area: float) -> None:
    disc = lamps.disc_of(scenes.lamp(kind, 2.0), (0.0, 0.0, -1.0))
    corners = np.array(disc.corners_ws) - lamps.centre_of(disc)
    radius = np.linalg.norm(corners, axis=1)
    assert len(corners) == 8 and radius == pytest.approx(math.sqrt(area / math.pi))
    assert np.ptp(corners[:, 2]) == pytest.approx(0)


# --- judgement and page ----------------------------------------------------------------------------------------------


@pytest.fixture
def one_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    bounded = limits.Limit(("pcf",), ("light-*",), "penumbra", 0.3, "bounded", "too soft")
    outside = limits.Limit(("pcf",), ("light-*",), "penumbra", 1.0, "known_limit", "too large", "is wide")
    monkeypatch.setattr(limits, "LIMITS", (bounded, outside))


@pytest.mark.usefixtures("one_limit")
@pytest.mark.parametrize(
    ("technique", "value", "warnings", "outcome"),
    [
        ("pcf", 0.1, [], "holds"),
        ("pcf", 0.2, [], "bounded"),
        ("pcf", 0.5, ["the light is wide"], "known_limit"),
        ("pcf", 0.5, ["something else"], "violated"),
        ("pcf", 1.5, ["the light is wide"], "violated"),
        ("pcf", math.nan, ["the light is wide"], "violated"),
        ("hybrid", 0.2, [], "violated"),
    ],
)
def test_figures_become_outcomes(technique: str, value: float, warnings: list[str], outcome: str) -> None:
    (row,) = limits.judge(technique, "light-1", [Measured("penumbra", value, 0.1)], warnings)
    assert row.outcome == outcome
    assert (row.reason == "") == (outcome == "holds")
    assert "\n" not in row.reason and json.dumps(row.to_json(), allow_nan=False)


@pytest.mark.parametrize(("figure", "outcome"), [(0.3, "bounded"), (0.15, "violated"), (None, "violated")])
def test_a_closed_form_bounds_by_the_figure_of_its_case(
    monkeypatch: pytest.MonkeyPatch, figure: float | None, outcome: str
) -> None:
    limit = limits.Limit(("pcf",), ("*",), "penumbra", "hard", "bounded", "too hard")
    monkeypatch.setattr(limits, "LIMITS", (limit,))
    forms = {} if figure is None else {"hard": figure}
    for name, bound in (("penumbra", 0.1), ("picture", -math.inf)):
        (row,) = limits.judge("pcf", "yard", [Measured(name, 0.2, bound, forms)])
        assert row.outcome == outcome and row.property == name
        assert outcome == "violated" or row.bound == figure


SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["schema", "environment", "rows"],
    "additionalProperties": False,
    "properties": {
        "schema": {"const": 1},
        "environment": {"type": "object", "required": ["penumbra", "cpu", "gl_renderer"]},
        "rows": {
            "type": "array",
            "minItems": 1,
            "items": {
                "type": "object",
                "required": ["technique", "case", "property", "value", "bound", "outcome", "reason"],
                "additionalProperties": False,
                "properties": {
                    "technique": {"type": "string"},
                    "case": {"type": "string"},
                    "property": {"type": "string"},
                    "value": {"type": ["number", "null"]},
                    "bound": {"type": "number"},
                    "outcome": {"enum": list(rows.OUTCOMES)},
                    "reason": {"type": "string"},
                },
            },
        },
    },
}


def test_the_page_names_everything_that_does_not_hold() -> None:
    found = [
        Row("pcf", "yard", "penumbra", 0.2, 0.3, "bounded", "too soft"),
        Row("hybrid", "yard", "penumbra", 0.1, 0.3, "bounded", "too soft"),
        Row("hybrid", "turned", "ends", None, 60.0, "violated", "the process died of <SIGSEGV>"),
        Row("pcf", "turned", "finite", 0.0, 0.0, "holds"),
    ]
    cases = [case for case in CASES if case.id in ("yard", "turned")]
    text = document.markdown({"cpu": "some"}, cases, ["pcf", "hybrid"], found)
    assert "| `yard` | b | b |" in text and "| `turned` | ✓ | ✗ |" in text
    assert "| penumbra | `pcf`, `hybrid` | `yard` | 0.2 / 0.3 | too soft |" in text
    assert "| `yard` | 0.2 / 0.3 | 0.1 / 0.3 |" in text, "measured over bound"
    assert "died of <SIGSEGV>" in text
    assert document.counts(found) == {"holds": 1, "bounded": 2, "known_limit": 0, "violated": 1}


def test_every_case_and_limit_is_in_use(core: Any) -> None:
    known = {info["id"] for info in core.techniques()}
    ids = [case.id for case in CASES]
    assert len(set(ids)) == len(ids) and set(ids) >= QUICK
    for case in CASES:
        assert {check.property for check in case.checks} <= {*MEASURES, "refused"}, case.id
        assert case.build is None or all(frame.lamps for frame in case.build()), case.id
    for limit in limits.LIMITS:
        assert set(limit.techniques) <= known, limit
        assert limit.outcome in ("bounded", "known_limit") and limit.reason
        assert any(limit.covers(limit.techniques[0], id_, limit.property) for id_ in ids), limit
        assert limit.property in {check.property for case in CASES for check in (*case.checks, *EVERY_PICTURE)}, limit
        if isinstance(limit.bound, str):
            assert limit.bound in FORMS
        else:
            assert limit.property == "no leak" or limit.bound < 1.0, "an empty bound"
        assert (limit.warning != "") == (limit.outcome == "known_limit"), "the plan says what is out of its field"
    assert {limit.bound for limit in limits.LIMITS if isinstance(limit.bound, str)} == set(FORMS)
    assert all(case.ends_s <= 120.0 and case.memory_mb <= 1024.0 for case in CASES)
    assert any(check.property == "no leak" for case in CASES for check in case.checks)
    assert all(set(techniques) <= known for techniques in SWEEPS.values())


# --- the border ------------------------------------------------------------------------------------------------------


def test_the_border_is_tried_in_every_field(core: Any) -> None:
    names = [name for name, _ in border.places(core, None, "smoothies")]
    for expected in (
        "polygon light: corners_ws[2][1] = nan", "sun light: sun_angle_rad = inf", "point light: power_w[0] = -inf",
        "rectangle camera: world_from_camera[3, 3] = nan", "mesh: positions[2, 2] = nan", "smoothies: t = nan",
    ):  # fmt: skip
        assert expected in names, names


def test_one_sentence_says_what_to_do() -> None:
    assert border.is_one_sentence('light "a": radius is nan; give a value from 0 to 1e18 m')
    assert not border.is_one_sentence("bad")
    assert not border.is_one_sentence("a; b\nc")


# --- processes -------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("working_machine")
def test_a_worker_that_dies_hangs_eats_or_fails_is_a_row_and_the_next_case_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(run, "_SLACK_S", 1.5)
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=":")
    told: list[str] = []
    found = list(
        run.run(
            ["shadow_map"], stability_trouble.CASES, lambda done, text: told.append(text), table="stability_trouble"
        )
    )
    by_case = {case.id: [row for row in found if row.case == case.id] for case in stability_trouble.CASES}
    for id_, words in (
        ("dies", "died of SIGSEGV"), ("hangs", "had not ended after 2 s"), ("eats", "out of memory"),
        ("fails", "it cannot be built"),
    ):  # fmt: skip
        (row,) = by_case[id_]
        assert row.outcome == "violated" and row.value is None and words in row.reason, row
    assert {row.property for row in by_case["goes-well"]} == {"finite", "in 0 to 1", "ends", "memory"}
    assert all(row.outcome == "holds" for row in by_case["goes-well"])
    assert told[0] == "dies: shadow_map"


# --- end to end ------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("working_machine")
def test_a_few_cases_end_to_end(penumbra: Run, tmp_path: Path) -> None:
    out, page = tmp_path / "out", tmp_path / "page.md"
    result = penumbra(
        "stability", "--out", out, "--page", page, "--techniques=shadow_map,ray_traced",
        "--cases=moved-1e7,image-1x1,light-point-0m,denormal-light,contact-0.0001,light-grows",
    )  # fmt: skip
    assert result.returncode == 0, result.stdout + result.stderr
    stability = json.loads((out / "stability.json").read_text(), parse_constant=pytest.fail)
    jsonschema.validate(stability, SCHEMA)
    outcomes = {(row["technique"], row["case"], row["property"]): row for row in stability["rows"]}
    assert outcomes["ray_traced", "moved-1e7", "same image"]["outcome"] == "holds"
    assert {row["technique"] for row in stability["rows"]} == {"shadow_map", "ray_traced"}
    assert page.read_bytes() == (out / "stability.md").read_bytes()
    assert (out / "stability.html").read_text().startswith("<!doctype html>")
    assert sorted(path.name for path in out.iterdir()) == ["stability.html", "stability.json", "stability.md"]


@pytest.mark.usefixtures("working_machine")
def test_exit_code_1_when_something_is_violated(
    core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from penumbra import cli

    monkeypatch.setattr(limits, "LIMITS", ())
    arguments = ["stability", "--out", str(tmp_path / "out"), "--techniques=shadow_map", "--cases=yard"]
    assert cli.main(arguments) == 1
    told = capsys.readouterr()
    assert "yard: shadow_map: penumbra: 0.25" in told.err and "violated 1" in told.out
    stability = json.loads((tmp_path / "out" / "stability.json").read_text())
    assert [row["property"] for row in stability["rows"] if row["outcome"] == "violated"] == ["penumbra"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--techniques=shadow_mop"], 'unknown technique "shadow_mop"; did you mean shadow_map?'),
        (["--cases=yord"], 'unknown case "yord"; did you mean yard?'),
        (["--quick", "--cases=scale-1e2"], "no case is both among --cases and --quick"),
    ],
)
def test_bad_usage_is_one_sentence(core: Any, penumbra: Run, tmp_path: Path, words: list[str], said: str) -> None:
    result = penumbra("stability", "--out", tmp_path / "out", *words)
    assert result.returncode == 2 and said in result.stderr and len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_frame_of_another_light_is_another_scene(core: Any) -> None:
    one = scenes.yard()
    other = setups.under(one, replace(one.lamps[0], position_ws=(1.0, 0.0, 4.0)))
    assert one.scene(core).digest() == scenes.yard().scene(core).digest() != other.scene(core).digest()
