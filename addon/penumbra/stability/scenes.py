"""The scenes that the cases vary: builders of setups, all within a few metres of the origin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import shapes
from .setups import Eye, Lamp, Matrix, Part, Setup, Vector, looking

LIGHT_HEIGHT_M = 4.0
SCENE_M = 6.0
"""About what the camera sees across."""


def rectangle(size: float, at: Vector = (0.3, -0.2, LIGHT_HEIGHT_M), depth: float | None = None) -> Lamp:
    """Level, shining down."""
    other = size if depth is None else depth
    return Lamp("rectangle", at, half_u_ws=(0.5 * size, 0.0, 0.0), half_v_ws=(0.0, 0.5 * other, 0.0))


def lamp(kind: str, size: float, at: Vector = (0.3, -0.2, LIGHT_HEIGHT_M)) -> Lamp:
    """A light of about this width, above the scene."""
    if kind in ("point", "spot"):
        axes = 1.0 if kind == "spot" else 0.0
        return Lamp(kind, at, half_u_ws=(axes, 0.0, 0.0), half_v_ws=(0.0, axes, 0.0), radius_m=0.5 * size)
    if kind == "sun":
        angle = 2.0 * math.atan(0.5 * size / LIGHT_HEIGHT_M)
        return Lamp("sun", direction_ws=(-0.08, 0.05, -1.0), sun_angle_rad=angle)
    if kind == "line":
        return Lamp("line", at, half_u_ws=(0.5 * size, 0.0, 0.0))
    if kind == "polygon":
        h = 0.5 * size
        corners = tuple((at[0] + x * h, at[1] + y * h, at[2]) for x, y in ((-1, -1), (1, -1), (0, 1)))
        return Lamp("polygon", at, corners_ws=corners)
    return replace(rectangle(size, at), kind=kind)


def ground(reach: float = 20.0) -> Part:
    return Part("ground", shapes.sheet((-reach, reach), (-reach, reach)))


def oblique(width: int = 96, height: int = 72) -> Eye:
    return Eye(looking((0.0, -11.0, 16.5), (0.0, 0.0, 0.3)), tan_half_width=0.15, size_px=(width, height))


def yard(size: float = 0.6, kind: str = "rectangle") -> Setup:
    """A ball and a fence over a ground, seen obliquely: all that scenes have, in small."""
    bar = shapes.box((-0.1, -0.1, 0.0), (0.1, 0.1, 1.5))
    bars = tuple(Part(f"bar {i}", bar, (-1.5 + 0.5 * i, -1.0, 0.0)) for i in range(4))
    parts = (ground(), Part("ball", shapes.ball(1.0), (0.4, 0.3, 1.2)), *bars)
    return Setup(parts, (lamp(kind, size),), oblique())


def edge(size: float = 0.6, height: float = 1.0) -> Setup:
    """A half-plane over a ground, parallel to it and to a square light: V is a ramp along x."""
    plate = Part("plate", shapes.sheet((-15.0, 0.0), (-15.0, 15.0)), (0.0, 0.0, height))
    eye = Eye(looking((1e-3, 0.0, 0.9 * height), (1e-3, 0.0, 0.0)), tan_half_width=1.0, near_m=1e-3 * height)
    reach = 2.0 * max(size, 0.05) * height / (LIGHT_HEIGHT_M - height)
    eye = replace(eye, tan_half_width=reach / (0.9 * height))
    return Setup((ground(), plate), (rectangle(size, (0.0, 0.0, LIGHT_HEIGHT_M)),), eye)


def plate(height: float, size: float = 0.4, extent: float = 1.0, shape: shapes.Shape | None = None) -> Setup:
    """A square plate (or another shape in its place) at a height over a ground under a square light."""
    own = shapes.sheet((-extent, extent), (-extent, extent)) if shape is None else shape
    return Setup((ground(), Part("plate", own, (0.0, 0.0, height))), (rectangle(size),), oblique())


def ulp_above() -> Setup:
    """A plate one unit in the last place of float32 above a ground that lies at a height of 1."""
    above = float(np.nextafter(np.float32(1.0), np.float32(2.0)))
    floor = Part("ground", shapes.sheet((-20.0, 20.0), (-20.0, 20.0), 1.0))
    sheet = Part("plate", shapes.sheet((-1.0, 1.0), (-1.0, 1.0), above))
    return Setup((floor, sheet), (rectangle(0.4),), oblique())


def standing(size: float = 0.4) -> Setup:
    """A box whose foot lies in the ground's plane."""
    block = Part("block", shapes.box((-0.6, -0.6, 0.0), (0.6, 0.6, 1.0)))
    return Setup((ground(), block), (rectangle(size, (1.2, -0.8, LIGHT_HEIGHT_M)),), oblique())


def around(light: Lamp, *casters: Part, reach: float = 20.0) -> Setup:
    """Casters and a light of any place over a ground."""
    return Setup((ground(reach), *casters), (light,), oblique())


def ball_part(at: Vector = (0.4, 0.3, 1.2), radius: float = 1.0) -> Part:
    return Part("ball", shapes.ball(radius), at)


def tower(height: float) -> Setup:
    """A level light far up, a caster just below it: depths along the light's rays span the height over 1 mm."""
    size = 0.4e-3
    chip = Part("chip", shapes.sheet((-0.25e-3, 0.25e-3), (-0.25e-3, 0.25e-3)), (0.0, 0.0, height - 1e-3))
    light = rectangle(size, (0.0, 0.0, height))
    eye = Eye(looking((0.0, 0.0, 0.9 * height), (0.0, 0.0, 0.0)), tan_half_width=1.5, far_m=10.0 * height)
    return Setup((ground(1.5 * height), chip), (light,), eye)


def wall_grazed(slope: float) -> Setup:
    """A ground whose plane passes the light's centre at this slope (metres of height over metres of distance)."""
    light = rectangle(0.2, (0.0, 0.0, 4.0 * slope))
    light = replace(light, position_ws=(-4.0, 0.0, 4.0 * slope), direction_ws=(1.0, 0.0, 0.0))
    light = replace(light, half_u_ws=(0.0, 0.1, 0.0), half_v_ws=(0.0, 0.0, 0.1))
    post = Part("post", shapes.box((-1.1, -0.1, 0.0), (-0.9, 0.1, 1.0)))
    return Setup((ground(), post), (light,), oblique())


def edge_on() -> Setup:
    """A wall that the camera and the light see exactly from its side, on a ground, beside a ball."""
    thin = Part("wall", shapes.sheet((0.0, 1.5), (-1.0, 1.0)), placed=_upright())
    return Setup((ground(), thin, ball_part((1.5, 0.5, 0.6), 0.5)), (rectangle(0.4, (0.0, 0.0, 4.0)),), _above())


def seen(tan_half_width: float, size_px: tuple[int, int]) -> Setup:
    """The yard through another lens; the camera goes near or far so that it still sees about as much."""
    whole = yard()
    distance = min(max(3.0 / tan_half_width, 3.0), 400.0)
    eye = Eye(looking((0.0, -0.5 * distance, 0.8 * distance), (0.0, 0.0, 0.3)), tan_half_width, 0.01, 2000.0, size_px)
    return replace(whole, eye=eye)


def many_lights(count: int) -> Setup:
    """Small spheres on a spiral over the yard; the last one is asked."""
    lamps = []
    for i in range(count):
        turn, out = 2.399963 * i, 3.0 * math.sqrt(i / count)
        lamps.append(lamp("point", 0.2, (out * math.cos(turn), out * math.sin(turn), LIGHT_HEIGHT_M)))
    return replace(yard(), lamps=tuple(lamps), light=count - 1)


def _upright() -> Matrix:
    """Local x becomes world z: a sheet that stands in the plane x = 0."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    return matrix


def _above() -> Eye:
    return Eye(looking((0.0, 0.0, 20.0), (0.0, 0.0, 0.0)))
