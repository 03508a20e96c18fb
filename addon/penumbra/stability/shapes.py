"""Meshes as (positions (n, 3) float32, triangles (m, 3) uint32): what scenes for hard cases are made of."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Shape = tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]


def _shape(positions: npt.ArrayLike, triangles: npt.ArrayLike) -> Shape:
    return np.asarray(positions, np.float32).reshape(-1, 3), np.asarray(triangles, np.uint32).reshape(-1, 3)


def sheet(x: tuple[float, float], y: tuple[float, float], z: float = 0.0) -> Shape:
    """A rectangle that faces +z."""
    corners = [(x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)]
    return _shape(corners, [(0, 1, 2), (0, 2, 3)])


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Shape:
    """Closed, with normals to the outside."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return _shape(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def ball(radius: float, rings: int = 12) -> Shape:
    """A sphere around the origin, closed; its poles are single vertices."""
    around = 2 * rings
    positions = [(0.0, 0.0, radius)]
    for i in range(1, rings):
        polar = math.pi * i / rings
        for k in range(around):
            turn = 2.0 * math.pi * k / around
            out = radius * math.sin(polar)
            positions.append((out * math.cos(turn), out * math.sin(turn), radius * math.cos(polar)))
    positions.append((0.0, 0.0, -radius))
    last = len(positions) - 1
    triangles = []
    for k in range(around):
        after = (k + 1) % around
        triangles.append((0, 1 + k, 1 + after))
        for i in range(rings - 2):
            a, b = 1 + i * around + k, 1 + i * around + after
            triangles += [(a, a + around, b + around), (a, b + around, b)]
        foot = 1 + (rings - 2) * around
        triangles.append((foot + k, last, foot + after))
    return _shape(positions, triangles)


def cone(radius: float, tip: float, base: float, sides: int) -> Shape:
    """A closed cone about the z axis, from its base's height to its tip's."""
    turns = 2.0 * math.pi * np.arange(sides) / sides
    rim = np.stack([radius * np.cos(turns), radius * np.sin(turns), np.full(sides, base)], axis=1)
    positions = np.concatenate([rim, [(0.0, 0.0, tip), (0.0, 0.0, base)]])
    after = (np.arange(sides) + 1) % sides
    here = np.arange(sides)
    up = np.stack([here, after, np.full(sides, sides)], axis=1)
    down = np.stack([after, here, np.full(sides, sides + 1)], axis=1)
    return _shape(positions, np.concatenate([up, down]))


def star(fins: int, inner: float, outer: float, height: float) -> Shape:
    """Triangles that share one vertex at the origin and stand apart like the vanes of a fan: seen from above, two
    silhouette edges each meet at it."""
    positions = [(0.0, 0.0, 0.0)]
    triangles = []
    for i in range(fins):
        for turn in (i + 0.25, i + 0.75):
            angle = 2.0 * math.pi * turn / fins
            reach = inner if i % 2 else outer
            positions.append((reach * math.cos(angle), reach * math.sin(angle), height))
        triangles.append((0, 1 + 2 * i, 2 + 2 * i))
    return _shape(positions, triangles)


def blades(count: int, extent: float, height: float, width: float, seed: int = 1) -> Shape:
    """Upright triangles, thin at the foot and thinner at the tip, strewn over a square: grass."""
    random = np.random.default_rng(seed)
    foot = random.uniform(-extent, extent, (count, 2))
    turn = random.uniform(0.0, 2.0 * np.pi, count)
    lean = random.normal(0.0, 0.2 * height, (count, 2))
    side = 0.5 * width * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    positions = np.zeros((count, 3, 3))
    positions[:, 0, :2], positions[:, 1, :2] = foot - side, foot + side
    positions[:, 2, :2] = foot + lean
    positions[:, 2, 2] = height
    return _shape(positions, np.arange(3 * count))


def merged(*shapes: Shape) -> Shape:
    """All in one mesh; nothing is welded."""
    positions, triangles, first = [], [], 0
    for own_positions, own_triangles in shapes:
        positions.append(own_positions)
        triangles.append(own_triangles + np.uint32(first))
        first += len(own_positions)
    return _shape(np.concatenate(positions), np.concatenate(triangles))


def moved(shape: Shape, by: tuple[float, float, float]) -> Shape:
    return _shape(shape[0] + np.asarray(by, np.float32), shape[1])


def inside_out(shape: Shape) -> Shape:
    return _shape(shape[0], shape[1][:, ::-1])


def shuffled(shape: Shape, seed: int) -> Shape:
    """The same surface: triangles in another order, each begun at another of its corners."""
    random = np.random.default_rng(seed)
    triangles = shape[1][random.permutation(len(shape[1]))]
    first = random.integers(0, 3, len(triangles))
    columns = (first[:, None] + np.arange(3)) % 3
    return _shape(shape[0], np.take_along_axis(triangles, columns, axis=1))


def t_junctions(x: tuple[float, float], y: tuple[float, float], z: float, parts: int) -> Shape:
    """A rectangle of two halves whose common edge has vertices on one side only, which share none with the other."""
    middle = 0.5 * (x[0] + x[1])
    left = sheet((x[0], middle), y, z)
    stops = np.linspace(y[0], y[1], parts + 1)
    right = [sheet((middle, x[1]), (a, b), z) for a, b in pairwise(stops.tolist())]
    return merged(left, *right)


def slivers(x: tuple[float, float], y: tuple[float, float], z: float, ratio: float, count: int) -> Shape:
    """A rectangle cut along x; between its strips lie triangles that are `ratio` times as long as wide."""
    length = x[1] - x[0]
    width = length / ratio
    stops = np.linspace(y[0], y[1], count + 1)
    pieces = []
    for a, b in pairwise(stops.tolist()):
        pieces.append(sheet(x, (a, b - width), z))
        top, foot = b, b - width
        corners = [(x[0], foot, z), (x[1], foot, z), (x[0], top, z), (x[1], top, z)]
        pieces.append(_shape(corners, [(0, 1, 2), (1, 3, 2)]))
    return merged(*pieces)


def with_degenerates(shape: Shape) -> Shape:
    """The same surface with triangles of no area: a corner twice, three times, and three corners on one line."""
    positions, triangles = shape
    middle = 0.5 * (positions[triangles[0, 0]] + positions[triangles[0, 1]])
    first = len(positions)
    a, b, c = (int(corner) for corner in triangles[0])
    extra = [(a, a, b), (c, c, c), (a, first, b), (b, a, b)]
    return _shape(np.concatenate([positions, [middle]]), np.concatenate([triangles, np.asarray(extra, np.uint32)]))


def doubled(shape: Shape) -> Shape:
    """Every triangle twice, and every other one a third time the other way round."""
    positions, triangles = shape
    return _shape(positions, np.concatenate([triangles, triangles, triangles[::2, ::-1]]))
