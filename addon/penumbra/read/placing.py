"""Where a camera and a light go in a scene that has none. The same scene always gets the same ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .cameras import Frame
from .transforms import DoubleArray, unit

_TAN_HALF_WIDTH = 36.0 / 2.0 / 50.0  # a 50 mm lens on a 36 mm sensor
_AIR = 0.95  # of the half frame that the scene may fill
_VIEW = (0.45, -0.77, 0.45)  # from the scene to the camera: front right and above
_IRRADIANCE = 3.0  # W/m^2 at the scene's centre: a white surface then shows a value close to 1


@dataclass(frozen=True)
class PlacedCamera:
    world_from_camera: DoubleArray
    tan_half_width: float
    near_m: float
    far_m: float


@dataclass(frozen=True)
class PlacedLight:
    """A square; half_u and half_v go from its centre to its edges."""

    position: DoubleArray
    direction: DoubleArray
    half_u: DoubleArray
    half_v: DoubleArray
    power_w: float


def frame_everything(points: DoubleArray, frame: Frame) -> PlacedCamera:
    """A camera that sees all points (n, 3), as near as leaves 5 % air at the tightest edge of the frame."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
    z = np.array(_VIEW) / math.sqrt(sum(c * c for c in _VIEW))
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    across, up = float(frame.size[0]), frame.size[1] * frame.pixel_aspect
    tan_x, tan_y = _TAN_HALF_WIDTH * across / max(across, up), _TAN_HALF_WIDTH * up / max(across, up)

    local = (points - centre) @ np.column_stack((x, y, z))
    nearest = float(local[:, 2].max())
    depth = max(float(np.ptp(local[:, 2])), 1e-6)
    for_width = local[:, 2] + np.abs(local[:, 0]) / (_AIR * tan_x)
    for_height = local[:, 2] + np.abs(local[:, 1]) / (_AIR * tan_y)
    distance = max(float(np.maximum(for_width, for_height).max()), nearest + 1e-3 * depth)

    world_from_camera = np.eye(4)
    world_from_camera[:3, :] = np.column_stack((x, y, z, centre + distance * z))
    near = max((distance - nearest) * 0.5, 1e-4 * (distance + depth))
    return PlacedCamera(world_from_camera, tan_x, near, (distance + depth) * 4.0)


def light_everything(points: DoubleArray, world_from_camera: DoubleArray) -> PlacedLight:
    """A square of a quarter of the scene's diameter, one diameter away, above and to the camera's left."""
    low, high = points.min(axis=0), points.max(axis=0)
    centre = (low + high) / 2.0
    diameter = max(float(np.linalg.norm(high - low)), 1e-6)
    left = unit(-world_from_camera[:3, 0] * np.array([1.0, 1.0, 0.0]))
    towards = np.array([0.0, 0.0, 1.0]) + (0.5 * left if left is not None else 0.0)
    towards /= np.linalg.norm(towards)
    u = np.cross([0.0, 1.0, 0.0], towards)
    u /= np.linalg.norm(u)
    v = np.cross(towards, u)
    half = diameter / 8.0
    return PlacedLight(centre + diameter * towards, -towards, u * half, v * half, _IRRADIANCE * math.pi * diameter**2)
