"""Options, jobs and lights of a comparison: what is decided before the core is asked."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from penumbra import compare
from penumbra.compare import Job, describe_light, jobs_of, parse_setting
from penumbra.errors import UserError


def setting(name: str, default: Any, low: float = 0, high: float = 0, **more: Any) -> dict[str, Any]:
    kind = "bool" if isinstance(default, bool) else type(default).__name__
    made = {"id": name, "type": kind, "default": default, "minimum": low, "maximum": high, "unit": "px"}
    return made | {"choices": [], "sweep": [], **more}


TECHNIQUES = [
    {"id": "shadow_map", "title": "Hard", "randomised": False, "settings": [setting("map_size", 1024, 16, 16384)]},
    {
        "id": "rays",
        "title": "Rays",
        "knob": "rays",
        "randomised": True,
        "settings": [
            setting("rays", 16, 1, 65536, sweep=[1, 4, 16, 64, 256]),
            setting("seed", 1, 0, 2**31 - 1),
            setting("early", False),
            setting("scale", 1.0, 0.0, 100.0, sweep=[0.5, 1.0, 2.0]),
            setting("filter", "box", type="choice", choices=["box", "2x2"], sweep=["box", "2x2"]),
        ],
    },
]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("shadow_map.map_size=512", ("shadow_map", "map_size", 512)),
        ("rays.early=on", ("rays", "early", True)),
        ("rays.early=False", ("rays", "early", False)),
        ("rays.scale=3", ("rays", "scale", 3.0)),
        ("rays.filter=2x2", ("rays", "filter", "2x2")),
    ],
)
def test_a_setting_is_read_as_its_type(text: str, expected: tuple[str, str, Any]) -> None:
    found = parse_setting(TECHNIQUES, text)
    assert found == expected
    assert type(found[2]) is type(expected[2])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("shadow_map", "technique.key=value"),
        ("map_size=3", "technique.key=value"),
        ("shadowmap.map_size=3", 'unknown technique "shadowmap"; did you mean shadow_map?'),
        ("shadow_map.mapsize=3", 'unknown setting of shadow_map "mapsize"; did you mean map_size?'),
        ("shadow_map.map_size=8", 'shadow_map.map_size is a whole number from 16 to 16384 px, not "8"'),
        ("shadow_map.map_size=64.5", "whole number"),
        ("rays.scale=nan", "a number from 0 to 100"),
        ("rays.early=maybe", 'rays.early is on or off, not "maybe"'),
        ("rays.filter=bx", 'unknown value of rays.filter "bx"; did you mean box? choose from: box, 2x2'),
    ],
)
def test_a_wrong_setting_is_one_sentence_with_the_choices(text: str, says: str) -> None:
    with pytest.raises(UserError) as caught:
        parse_setting(TECHNIQUES, text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_was_asked_for_comes_first_and_the_steps_change_it() -> None:
    assert [job.sweep for job in jobs_of(TECHNIQUES[1], {}, "off")] == [None]
    jobs = list(jobs_of(TECHNIQUES[1], {"rays": 9, "early": True}, "quick"))
    assert jobs[0].settings == {"rays": 9, "early": True} and jobs[0].sweep is None
    assert jobs[1].settings == {"rays": 1, "early": True}
    assert jobs[1].sweep == {"setting": "rays", "value": 1, "changed": {"rays": 1}}


def test_randomised_techniques_get_four_seeds_and_a_sweeps_steps_two() -> None:
    info = TECHNIQUES[1]
    assert [entry["seed"] for entry in Job(info, {}).seeds()] == [1, 2, 3, 4]
    assert [entry["seed"] for entry in Job(info, {"seed": 7}).seeds()] == [7, 8, 9, 10]
    assert len(Job(info, {}, {"setting": "rays", "value": 4}).seeds()) == 2
    assert Job(TECHNIQUES[0], {"map_size": 64}).seeds() == [{"map_size": 64}]


def test_seeds_stay_in_their_range() -> None:
    seeds = [entry["seed"] for entry in Job(TECHNIQUES[1], {"seed": 2**31 - 1}).seeds()]
    assert seeds == [2**31 - 1, 0, 1, 2]


def test_techniques_come_in_the_order_users_see_them() -> None:
    assert [info["id"] for info in compare.choose_techniques(TECHNIQUES, ("rays", "shadow_map"))] == [
        "shadow_map",
        "rays",
    ]


def test_an_unknown_light_is_one_sentence_with_the_names() -> None:
    with pytest.raises(UserError, match=r'unknown light "Kye"; did you mean Key\? choose from: Key, Sun'):
        compare.choose_lights(["Key", "Sun"], ("Kye",))
    assert compare.choose_lights(["Key", "Sun"], ("Sun",)) == [1]
    assert compare.choose_lights(["Key", "Sun"], ()) == [0, 1]


@pytest.mark.parametrize(
    ("light", "expected"),
    [
        ({"kind": "point", "radius_m": 0.25}, ("point", [0.5], None)),
        ({"kind": "sun", "sun_angle_rad": 0.01}, ("sun", [], 0.01)),
        ({"kind": "rectangle", "half_u_ws": (0.6, 0, 0.8), "half_v_ws": (0, 2, 0)}, ("rectangle", [2.0, 4.0], None)),
        ({"kind": "line", "half_u_ws": (0, 3, 0), "half_v_ws": (0, 0, 0)}, ("line", [6.0], None)),
        ({"kind": "polygon", "corners_ws": [(0, 0, 0), (3, 0, 0), (0, 4, 0)]}, ("polygon", [4.0, 3.0, 5.0], None)),
    ],
)
def test_sizes_of_lights_are_full_widths(light: dict[str, Any], expected: tuple[Any, ...]) -> None:
    shape, size, angle = describe_light(SimpleNamespace(**light))
    assert (shape, pytest.approx(size), angle) == expected
    assert np.all(np.isfinite(size))


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ([], []),
        ([0, 0, 0], [[0, 1, 2]]),
        ([4, 5, 1, 6, 0], [[0, 1, 2, 4], [3]]),
        ([40, 1, 2], [[0], [1, 2]]),
        ([1, 40, 2], [[0, 2], [1]]),
        ([9, 9, 1, 1], [[0, 2], [1, 3]]),
    ],
)
def test_what_is_timed_together_fits_into_memory(sizes: list[int], expected: list[list[int]]) -> None:
    assert compare.groups(sizes, 10) == expected


def test_a_quarter_of_the_memory_is_the_most_that_timing_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    for memory, most in ((64 << 30, 2 << 30), (4 << 30, 1 << 30), (0, 2 << 30)):
        monkeypatch.setattr("penumbra.environment.memory_bytes", lambda memory=memory: memory)
        assert compare.timing_memory() == most
