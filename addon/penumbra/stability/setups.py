"""A scene as plain data, before the core sees it: so that it can be scaled, turned, moved and reordered as a whole."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from . import shapes

Vector = tuple[float, float, float]
Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    name: str
    shape: shapes.Shape
    at: Vector = (0.0, 0.0, 0.0)
    casts: bool = True
    receives: bool = True
    visible: bool = True
    placed: Matrix | None = None  # world_from_local; None: moved to `at`

    def world_from_local(self) -> Matrix:
        if self.placed is not None:
            return self.placed
        matrix = np.eye(4)
        matrix[:3, 3] = self.at
        return matrix


@dataclass(frozen=True)
class Lamp:
    """Fields as core.Light has them."""

    kind: str = "rectangle"
    position_ws: Vector = (0.0, 0.0, 4.0)
    direction_ws: Vector = (0.0, 0.0, -1.0)
    half_u_ws: Vector = (0.0, 0.0, 0.0)
    half_v_ws: Vector = (0.0, 0.0, 0.0)
    corners_ws: tuple[Vector, ...] = ()
    radius_m: float = 0.0
    sun_angle_rad: float = 0.0
    spot_angle_rad: float = math.radians(100.0)


@dataclass(frozen=True, eq=False)
class Eye:
    world_from_camera: Matrix = field(default_factory=lambda: looking_down((0.0, 0.0, 20.0)))
    tan_half_width: float = 0.15
    near_m: float = 0.1
    far_m: float = 1000.0
    size_px: tuple[int, int] = (96, 72)


@dataclass(frozen=True, eq=False)
class Setup:
    parts: tuple[Part, ...]
    lamps: tuple[Lamp, ...]
    eye: Eye = field(default_factory=Eye)
    light: int = 0  # whose visibility is asked

    def scene(self, core: Any) -> Any:
        """@raises core.InvalidScene"""
        made = core.Scene()
        grey = np.full((1, 3), 0.8, np.float32)
        for part in self.parts:
            mesh = core.Mesh(part.name, *part.shape)
            made.add_instance(part.name, mesh, part.world_from_local(), grey, part.casts, part.receives, part.visible)
        for number, lamp in enumerate(self.lamps):
            made.add_light(light(core, lamp, f"{lamp.kind} {number}"))
        made.camera = camera(core, self.eye)
        return made


def light(core: Any, lamp: Lamp, name: str) -> Any:
    made = core.Light()
    made.name = name
    for member, value in vars(lamp).items():
        setattr(made, member, [list(corner) for corner in value] if member == "corners_ws" else value)
    return made


def camera(core: Any, eye: Eye) -> Any:
    made = core.Camera()
    made.name = "eye"
    made.world_from_camera = eye.world_from_camera
    made.tan_half_width, made.near_m, made.far_m = eye.tan_half_width, eye.near_m, eye.far_m
    made.width_px, made.height_px = eye.size_px
    return made


def looking_down(at: Vector) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, 3] = at
    return matrix


def looking(at: Vector, target: Vector) -> Matrix:
    """+y of the picture is up in z, or in y for a look straight down."""
    back = np.subtract(at, target)
    back = back / np.linalg.norm(back)
    up = np.array([0.0, 1.0, 0.0]) if abs(back[2]) > 0.999999 else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, at
    return matrix


def odd_turn() -> Matrix:
    """A rotation about an axis that nothing is aligned with."""
    a, b, c = 0.4, 1.1, -0.7
    about_z = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    about_x = np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
    about_y = np.array([[math.cos(c), 0, math.sin(c)], [0, 1, 0], [-math.sin(c), 0, math.cos(c)]])
    return np.asarray(about_z @ about_x @ about_y)


def carried(setup: Setup, scale: float = 1.0, turn: Matrix | None = None, by: Vector = (0.0, 0.0, 0.0)) -> Setup:
    """The whole scene, camera and lights included, scaled and turned about the origin, then moved."""
    rotation = np.eye(3) if turn is None else turn
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * rotation, by

    def point(p: Vector) -> Vector:
        return _vector(matrix[:3, :3] @ p + matrix[:3, 3])

    def length(v: Vector) -> Vector:
        return _vector(matrix[:3, :3] @ v)

    lamps = tuple(
        replace(
            lamp,
            position_ws=point(lamp.position_ws),
            direction_ws=_vector(rotation @ lamp.direction_ws),
            half_u_ws=_vector(rotation @ lamp.half_u_ws) if lamp.kind == "spot" else length(lamp.half_u_ws),
            half_v_ws=_vector(rotation @ lamp.half_v_ws) if lamp.kind == "spot" else length(lamp.half_v_ws),
            corners_ws=tuple(point(corner) for corner in lamp.corners_ws),
            radius_m=scale * lamp.radius_m,
        )
        for lamp in setup.lamps
    )
    seen = setup.eye.world_from_camera
    world_from_camera = np.eye(4)
    world_from_camera[:3, :3] = rotation @ seen[:3, :3]
    world_from_camera[:3, 3] = matrix[:3, :3] @ seen[:3, 3] + matrix[:3, 3]
    eye = replace(
        setup.eye,
        world_from_camera=world_from_camera,
        near_m=scale * setup.eye.near_m,
        far_m=scale * setup.eye.far_m,
    )
    parts = tuple(replace(part, placed=matrix @ part.world_from_local()) for part in setup.parts)
    return replace(setup, parts=parts, lamps=lamps, eye=eye)


def reordered(setup: Setup, seed: int = 7) -> Setup:
    """Objects in another order, their triangles too."""
    order = np.random.default_rng(seed).permutation(len(setup.parts))
    parts = [setup.parts[i] for i in order]
    return replace(
        setup, parts=tuple(replace(part, shape=shapes.shuffled(part.shape, seed + i)) for i, part in enumerate(parts))
    )


def under(setup: Setup, *lamps: Lamp) -> Setup:
    return replace(setup, lamps=lamps)


def _vector(values: Sequence[float] | npt.NDArray[np.float64]) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
