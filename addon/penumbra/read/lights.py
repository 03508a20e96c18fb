"""The geometry of Blender's lights, and of flat glowing meshes that become lights."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .transforms import DoubleArray, unit

MAX_CORNERS = 8


def normalising_area(light: Any, world_from_local: DoubleArray) -> float:
    """By what Blender divides a light's energy when it normalises, measured on Cycles 4.5.

    Area lights: their area in m^2, object scale included. Spheres: their surface (without a radius: 4). Suns: the
    disc's projected solid angle (without an angle: 1).
    """
    if light.type == "SUN":
        return math.pi * math.sin(min(light.angle, math.pi) / 2.0) ** 2 if light.angle > 0.0 else 1.0
    if light.type in {"POINT", "SPOT"}:
        return 4.0 * math.pi * light.shadow_soft_size**2 if light.shadow_soft_size > 0.0 else 4.0
    u, v = area_axes(light, world_from_local)
    area = 4.0 * float(np.linalg.norm(np.cross(u, v)))
    return area * math.pi / 4.0 if light.shape in {"DISK", "ELLIPSE"} else area


def area_axes(light: Any, world_from_local: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """From the centre to the edge along local x and y; the object's scale multiplies the light's size."""
    size_y = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    return world_from_local[:3, 0] * (light.size / 2.0), world_from_local[:3, 1] * (size_y / 2.0)


def area_direction(world_from_local: DoubleArray) -> DoubleArray | None:
    """Unit normal of an area light's plane on the side that local -z points to; None if the plane is undefined."""
    x, y, z = (world_from_local[:3, i] for i in range(3))
    normal = unit(np.cross(x, y))
    if normal is None:  # a light squeezed to a line or a point still knows where it looks
        return unit(-z)
    return -normal if float(np.dot(normal, z)) > 0.0 or not np.any(z) else normal


def planar_outline(positions: DoubleArray, triangles: npt.NDArray[np.uint32]) -> tuple[DoubleArray | None, str]:
    """The corners of a flat convex patch of triangles, counter-clockwise seen from where the triangles face.

    Returns (corners, "") or (None, why not). Corners that lie on a straight edge or inside are dropped.
    """
    points = positions[triangles.astype(np.int64)]
    vector_area = 0.5 * np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    area = float(np.linalg.norm(vector_area, axis=1).sum())
    if area <= 0.0 or not math.isfinite(area):
        return None, "it has no area"
    total = vector_area.sum(axis=0)
    used = positions[np.unique(triangles)]
    extent = float(np.linalg.norm(used.max(axis=0) - used.min(axis=0)))
    normal = unit(total)
    if normal is None:
        return None, "it is not flat"
    if np.ptp(used @ normal) > 1e-4 * extent or float(np.linalg.norm(total)) < area * (1.0 - 1e-4):
        return None, "it is not flat"

    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(axis, normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    flat = np.unique(np.column_stack((used @ u, used @ v)), axis=0)
    hull = _convex_hull(flat, 1e-5 * extent)
    if len(hull) < 3 or len(hull) > MAX_CORNERS:
        return None, f"it has more than {MAX_CORNERS} corners" if len(hull) > 3 else "it has no area"
    x, y = hull[:, 0], hull[:, 1]
    hull_area = 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    if abs(hull_area - area) > 1e-3 * hull_area:
        return None, "it is not convex"
    height = float((used @ normal).mean())
    return hull[:, :1] * u + hull[:, 1:] * v + height * normal, ""


def _convex_hull(points: DoubleArray, tolerance: float) -> DoubleArray:
    """Counter-clockwise hull (monotone chain) of points sorted by x then y; points near an edge are dropped."""

    def chain(sequence: DoubleArray) -> list[DoubleArray]:
        hull: list[DoubleArray] = []
        for point in sequence:
            while len(hull) > 1:
                edge, step = hull[-1] - hull[-2], point - hull[-2]
                span = math.hypot(*step)
                if span > 0.0 and edge[0] * step[1] - edge[1] * step[0] > tolerance * span:
                    break
                hull.pop()
            hull.append(point)
        return hull[:-1]

    if len(points) < 3:
        return points
    return np.array(chain(points) + chain(points[::-1]))


def facing_outline(corners: DoubleArray, world_from_local: DoubleArray) -> DoubleArray:
    """Corners of a flat patch in world space, counter-clockwise seen from the side to which its normals point.

    Blender's normal of a mirrored object is the transformed normal, not the normal of the transformed corners.
    """
    corners_ws = corners @ world_from_local[:3, :3].T + world_from_local[:3, 3]
    result: DoubleArray = corners_ws[::-1] if np.linalg.det(world_from_local[:3, :3]) < 0.0 else corners_ws
    return result


def outline_vector_area(corners: DoubleArray) -> DoubleArray:
    """Normal times area of a flat polygon."""
    from_centre = corners - corners.mean(axis=0)
    vector: DoubleArray = 0.5 * np.cross(from_centre, np.roll(from_centre, -1, axis=0)).sum(axis=0)
    return vector
