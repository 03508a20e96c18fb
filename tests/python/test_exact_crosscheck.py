"""The exact reference against polygon libraries, which are right where nothing is degenerate."""

from __future__ import annotations

from typing import Any

import exact_scenes as scenes
import numpy as np
import numpy.typing as npt
import pytest

Triangles = npt.NDArray[np.float64]


def random_blockers(random: np.random.Generator, count: int) -> npt.NDArray[np.float32]:
    centre = np.concatenate([random.uniform(-0.8, 0.8, (count, 1, 2)), random.uniform(0.4, 1.6, (count, 1, 1))], axis=2)
    corners = centre + random.uniform(-0.3, 0.3, (count, 3, 3))
    return np.ascontiguousarray(corners, np.float32)


def on_light(corners: npt.NDArray[np.float32]) -> Triangles:
    exact = corners.astype(np.float64)
    return 2.0 * exact[:, :, :2] / exact[:, :, 2:]


def shapely_visible(triangles: Triangles) -> float:
    shapely = pytest.importorskip("shapely", reason="shapely is not installed")
    polygons = [shapely.Polygon(t) for t in triangles]
    union = shapely.unary_union([p for p in polygons if p.is_valid and p.area > 0.0])
    return float(1.0 - shapely.intersection(union, shapely.box(-1.0, -1.0, 1.0, 1.0)).area / 4.0)


def clipper_visible(triangles: Triangles) -> float:
    pyclipr = pytest.importorskip("pyclipr", reason="pyclipr is not installed")
    clipper = pyclipr.Clipper()
    clipper.scaleFactor = 1 << 26
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    clipper.addPath(square, pyclipr.Subject)
    for t in triangles:
        u, v = t[1] - t[0], t[2] - t[0]
        clipper.addPath(t if u[0] * v[1] - u[1] * v[0] > 0.0 else t[::-1], pyclipr.Clip)
    left = clipper.execute(pyclipr.Difference, pyclipr.FillRule.NonZero)
    area = 0.0
    for path in left:
        x, y = np.asarray(path)[:, 0], np.asarray(path)[:, 1]
        area += 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return area / 4.0


def test_agrees_with_shapely_on_triangles_in_general_position(core: Any) -> None:
    random = np.random.default_rng(5)
    for count in [1, 4, 16, 64] * 10:
        corners = random_blockers(random, count)
        assert scenes.visible_at_origin(core, corners) == pytest.approx(shapely_visible(on_light(corners)), abs=1e-12)


def test_agrees_with_clipper_to_its_grid(core: Any) -> None:
    random = np.random.default_rng(6)
    for count in [1, 4, 16, 64] * 10:
        corners = random_blockers(random, count)
        # Clipper2 rounds every crossing to 2^-26 of the light; measured agreement is 1e-8.
        assert scenes.visible_at_origin(core, corners) == pytest.approx(clipper_visible(on_light(corners)), abs=2e-7)


def test_irradiance_ratio_agrees_with_a_weighted_sum_over_the_light(core: Any) -> None:
    random = np.random.default_rng(7)
    grid = (np.arange(400) + 0.5) / 200.0 - 1.0
    u, v = np.meshgrid(grid, grid)
    weight = 1.0 / (u * u + v * v + 4.0) ** 2  # both cosines are height / distance
    for _ in range(10):
        corners = random_blockers(random, 8)
        hidden = np.zeros(u.shape, bool)
        for a, b, c in on_light(corners):
            sides = [(q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]) for p, q in ((a, b), (b, c), (c, a))]
            hidden |= np.all([s >= 0 for s in sides], axis=0) | np.all([s <= 0 for s in sides], axis=0)
        expected = float((weight * ~hidden).sum() / weight.sum())
        normals = np.array([[0.0, 0.0, 1.0]])
        result = core.exact_visibility(scenes.scene_of(core, corners), 0, np.zeros((1, 3)), normals)
        # The sum's own error: cells of 1/400 that an edge crosses, some 10 edges, at random.
        assert float(result["irradiance"][0]) == pytest.approx(expected, abs=5e-4)
