"""Scenes in which projection to the light is exact, and the areas that other algorithms find there."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

Point = tuple[Fraction, Fraction]
Triangle = tuple[Point, Point, Point]

GRID = 1 << 22
"""Coordinates on the light are multiples of 1/GRID below 2: blockers half way up then are exact in float32."""


def square_light(core: Any) -> Any:
    """The square [-1, 1]^2 at height 2, shining down."""
    light = core.Light()
    light.name = "square"
    light.kind = "rectangle"
    light.position_ws = (0.0, 0.0, 2.0)
    light.direction_ws = (0.0, 0.0, -1.0)
    light.half_u_ws = (1.0, 0.0, 0.0)
    light.half_v_ws = (0.0, 1.0, 0.0)
    return light


def scene_of(core: Any, corners: npt.NDArray[np.float32]) -> Any:
    """One instance of separate triangles.

    corners: (m, 3, 3) world positions.
    """
    scene = core.Scene()
    triangles = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    mesh = core.Mesh("blockers", np.ascontiguousarray(corners.reshape(-1, 3)), triangles)
    scene.add_instance("blockers", mesh, np.eye(4), np.full((1, 3), 0.8, np.float32))
    scene.add_light(square_light(core))
    return scene


def blockers(triangles: Sequence[Triangle], heights: Sequence[float]) -> npt.NDArray[np.float32]:
    """Triangles at the heights given (0 .. 2) that the origin sees where `triangles` says, if float32 can hold them."""
    out = np.zeros((len(triangles), 3, 3), np.float32)
    for i, (triangle, height) in enumerate(zip(triangles, heights, strict=True)):
        for k, (u, v) in enumerate(triangle):
            out[i, k] = float(u) * height / 2, float(v) * height / 2, height
    return out


def projected(corners: npt.NDArray[np.float32]) -> list[Triangle]:
    """Where the origin sees float32 triangles on the light's plane, exactly."""
    result = []
    for triangle in corners:
        points = [
            (2 * Fraction(float(x)) / Fraction(float(z)), 2 * Fraction(float(y)) / Fraction(float(z)))
            for x, y, z in triangle
        ]
        result.append((points[0], points[1], points[2]))
    return result


def visible_at_origin(core: Any, corners: npt.NDArray[np.float32]) -> float:
    result = core.exact_visibility(scene_of(core, corners), 0, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    return float(result["area"][0])


def covered_fraction(triangles: Sequence[Triangle]) -> Fraction:
    """Share of the square [-1, 1]^2 that triangles cover, in rational arithmetic: no rounding at all.

    Between all corners and crossings the covered length is linear in x, so each slab counts its middle.
    """
    one = Fraction(1)
    edges = [(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)]
    frame = [((-one, -one), (one, -one)), ((-one, one), (one, one))]
    stops = {-one, one} | {p[0] for edge in edges for p in edge}
    lines = edges + frame
    for i, (a, b) in enumerate(lines):
        for c, d in lines[i + 1 :]:
            ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
            cross = ux * vy - uy * vx
            if cross:
                t = ((c[0] - a[0]) * vy - (c[1] - a[1]) * vx) / cross
                if 0 <= t <= 1:
                    stops.add(a[0] + t * ux)
    order = sorted(x for x in stops if -1 <= x <= 1)
    area = Fraction(0)
    for low, high in pairwise(order):
        x = (low + high) / 2
        spans = []
        for k in range(0, len(edges), 3):
            hits = [
                a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
                for a, b in edges[k : k + 3]
                if min(a[0], b[0]) < x < max(a[0], b[0])
            ]
            if hits:
                spans.append((max(min(hits), -one), min(max(hits), one)))
        reached = -one
        length = Fraction(0)
        for start, end in sorted(spans):
            if end > max(start, reached):
                length += end - max(start, reached)
                reached = end
        area += length * (high - low)
    return area / 4
