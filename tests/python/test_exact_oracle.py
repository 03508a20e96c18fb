"""The exact reference against rational arithmetic, where slivers, ties and T-junctions are the rule."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import exact_scenes as scenes
import numpy as np
import pytest

UNION_THAT_BREAKS_GEOS = [
    ((26219613, 31620104), (5687427, 5686099), (-7978403, -40503843)),
    ((-7978403, -40503843), (-317898, -14611653), (5687427, 5686099)),
    ((-5464107, -11478921), (17342850, -8083302), (-10801474, 15579736)),
    ((45910474, 6283602), (-41326029, -27949901), (46261348, -36399769)),
    ((-41326029, -27949901), (-38875312, -26988187), (45910474, 6283602)),
]


def triangle(values: Any, unit: int) -> scenes.Triangle:
    a, b, c = ((Fraction(int(u), unit), Fraction(int(v), unit)) for u, v in values)
    return a, b, c


def worst_difference(core: Any, cases: list[tuple[list[scenes.Triangle], list[float]]]) -> float:
    worst = 0.0
    for triangles, heights in cases:
        corners = scenes.blockers(triangles, heights)
        expected = 1 - scenes.covered_fraction(scenes.projected(corners))
        worst = max(worst, abs(scenes.visible_at_origin(core, corners) - float(expected)))
    return worst


def test_the_oracle_itself_knows_the_union_that_breaks_geos() -> None:
    unit = 1 << 26
    area = scenes.covered_fraction([triangle(t, unit) for t in UNION_THAT_BREAKS_GEOS]) * 4 * unit * unit
    assert float(area) == pytest.approx(2327566383582170.5, rel=1e-15)


def test_union_that_breaks_geos_is_right(core: Any) -> None:
    # float32 corners move its points by 2^-25; the oracle sees the moved ones.
    triangles = [triangle(t, 1 << 26) for t in UNION_THAT_BREAKS_GEOS]
    assert worst_difference(core, [(triangles, [1.0] * 5)]) <= 1e-14


def test_shared_collinear_and_doubled_edges_are_exact(core: Any) -> None:
    random = np.random.default_rng(1)
    cases = [
        ([triangle(random.integers(-4, 5, (3, 2)) * 3, 8) for _ in range(1 + n % 5)], [1.0] * (1 + n % 5))
        for n in range(150)
    ]
    assert worst_difference(core, cases) <= 2e-15


def test_slivers_on_rounded_points_of_edges_are_exact(core: Any) -> None:
    random = np.random.default_rng(2)
    cases = []
    for _ in range(150):
        base = random.integers(-scenes.GRID, scenes.GRID, (3, 2))
        a, b = base[0], base[1]
        on_edge = [np.rint(a + s * (b - a)) + random.integers(-2, 3, 2) for s in random.random(2)]
        slivers = [(a, b, on_edge[0]), (on_edge[0], on_edge[1], base[2]), (on_edge[0], on_edge[1], b)]
        triangles = [triangle(t, scenes.GRID) for t in [base, *slivers]]
        cases.append((triangles, [1.0] * 4))
    assert worst_difference(core, cases) <= 2e-15


def test_blockers_at_different_heights_fuse_exactly(core: Any) -> None:
    random = np.random.default_rng(3)
    cases = []
    for _ in range(100):
        triangles = [triangle(random.integers(-12, 13, (3, 2)), 8) for _ in range(4)]
        cases.append((triangles, [0.25, 0.75, 1.0, 1.5]))
    assert worst_difference(core, cases) <= 1e-14
