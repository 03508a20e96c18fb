"""Lights of other sizes in a light's place, and what of a light lies over a plane."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .setups import Lamp, Vector

Reals = npt.NDArray[np.float64]

LOZENGE = 0.02
"""Of `plateaus`: lozenge_radius."""
_ACROSS = 8
"""Points of a light along each of its two axes."""


def centre_of(lamp: Lamp) -> Reals:
    """Where the one point stands that hard shadows take for the light."""
    if lamp.kind == "polygon":
        corners = np.asarray(lamp.corners_ws, np.float64)
        twice = [np.linalg.norm(np.cross(b - corners[0], c - corners[0])) for b, c in _fan(corners)]
        thirds = [(corners[0] + b + c) / 3.0 for b, c in _fan(corners)]
        return np.asarray(np.average(thirds, axis=0, weights=twice) if sum(twice) > 0.0 else corners.mean(axis=0))
    return np.asarray(lamp.position_ws, np.float64)


def shrunk(lamp: Lamp, factor: float) -> Lamp:
    """The same light, so many times as large about its centre; 0: a point there (a sun: a direction)."""
    centre = centre_of(lamp)
    if lamp.kind == "sun":
        return replace(lamp, sun_angle_rad=2.0 * math.atan(factor * math.tan(0.5 * lamp.sun_angle_rad)))
    if factor == 0.0:
        return Lamp("point", _vector(centre))
    if lamp.kind in ("point", "spot"):
        return replace(lamp, radius_m=factor * lamp.radius_m)
    return replace(
        lamp,
        half_u_ws=_vector(factor * np.asarray(lamp.half_u_ws)),
        half_v_ws=_vector(factor * np.asarray(lamp.half_v_ws)),
        corners_ws=tuple(_vector(centre + factor * (np.asarray(corner) - centre)) for corner in lamp.corners_ws),
    )


def disc_of(lamp: Lamp, axis: Vector) -> Lamp:
    """An octagon in the disc of equal area (a line: of equal mean width, a sphere: of its radius) in the light's plane,
    or across the axis; a sun is its own."""
    if lamp.kind == "sun":
        return lamp
    along = np.asarray(lamp.half_u_ws, np.float64)
    if lamp.kind in ("point", "spot"):
        least = np.eye(3)[int(np.argmin(np.abs(axis)))]
        along = np.cross(axis, least)
        return _octagon(lamp, along, np.asarray(axis, np.float64), lamp.radius_m)
    if lamp.kind == "polygon":
        corners = np.asarray(lamp.corners_ws, np.float64)
        along = corners[1] - corners[0]
        crosses = np.sum([np.cross(b - corners[0], c - corners[0]) for b, c in _fan(corners)], axis=0)
        normal, radius = crosses, math.sqrt(0.5 * float(np.linalg.norm(crosses)) / math.pi)
    elif lamp.kind == "line":
        normal, radius = np.asarray(lamp.direction_ws, np.float64), 2.0 / math.pi * float(np.linalg.norm(along))
    else:
        normal = np.cross(along, np.asarray(lamp.half_v_ws, np.float64))
        quarter = 1.0 if lamp.kind == "ellipse" else 4.0 / math.pi
        radius = math.sqrt(quarter * float(np.linalg.norm(normal)))
    return _octagon(lamp, along, normal, radius)


def ribbon_of(line: Lamp) -> Lamp:
    """A rectangle in a line's place, LOZENGE times as wide as long."""
    along = np.asarray(line.half_u_ws, np.float64)
    across = np.cross(np.asarray(line.direction_ws, np.float64), along)
    across *= LOZENGE * np.linalg.norm(along) / max(float(np.linalg.norm(across)), 1e-300)
    return replace(line, kind="rectangle", half_v_ws=_vector(across))


def _octagon(lamp: Lamp, along: Reals, normal: Reals, radius: float) -> Lamp:
    if not radius > 0.0:
        return lamp
    u = along / np.linalg.norm(along)
    v = np.cross(normal, u)
    v /= np.linalg.norm(v)
    centre = centre_of(lamp)
    angles = np.arange(8) * math.pi / 4.0
    corners_ws = tuple(_vector(centre + radius * (math.cos(a) * u + math.sin(a) * v)) for a in angles)
    return Lamp("polygon", _vector(centre), lamp.direction_ws, corners_ws=corners_ws)


def above_plane(lamp: Lamp, positions: Reals, normals: Reals) -> Reals:
    """Share of the light over the plane of each point (height, width, 3), by points of it in equal shares."""
    shares = np.zeros(positions.shape[:2])
    if lamp.kind in ("point", "spot", "sun"):
        if lamp.kind == "sun":
            towards = np.broadcast_to(-np.asarray(lamp.direction_ws, np.float64), positions.shape)
            far, sine = np.linalg.norm(towards, axis=2), math.sin(0.5 * lamp.sun_angle_rad)
        else:
            towards = np.asarray(lamp.position_ws, np.float64) - positions
            far = np.linalg.norm(towards, axis=2)
            sine = np.minimum(lamp.radius_m / np.maximum(far, 1e-300), 1.0)
        rise = np.einsum("ijk,ijk->ij", towards, normals) / np.maximum(far, 1e-300)
        fall = np.sqrt(np.maximum(1.0 - rise * rise, 0.0))
        least = np.sqrt(1.0 - np.square(sine))  # cosine of the angle that the light subtends about its centre
        for height in (np.arange(_ACROSS) + 0.5) / _ACROSS:
            cosine = 1.0 - height * (1.0 - least)  # equal solid angles
            for turn in (np.arange(_ACROSS) + 0.5) * 2.0 * math.pi / _ACROSS:
                shares += rise * cosine + fall * np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0)) * math.cos(turn) > 0.0
        return np.asarray(shares / _ACROSS**2)
    points = _points(lamp)
    for point in points:
        shares += np.einsum("ijk,ijk->ij", point - positions, normals) > 0.0
    return np.asarray(shares / len(points))


def _points(lamp: Lamp) -> list[Reals]:
    steps = (np.arange(_ACROSS) + 0.5) / _ACROSS
    if lamp.kind == "polygon":
        corners = np.asarray(lamp.corners_ws, np.float64)
        fan = _fan(corners)
        return [
            corners[0] + math.sqrt(a) * ((1.0 - b) * (second - corners[0]) + b * (third - corners[0]))
            for second, third in fan
            for a in steps
            for b in steps
        ]
    centre = centre_of(lamp)
    u, v = np.asarray(lamp.half_u_ws, np.float64), np.asarray(lamp.half_v_ws, np.float64)
    if lamp.kind == "ellipse":
        return [
            centre + math.sqrt(a) * (math.cos(2.0 * math.pi * b) * u + math.sin(2.0 * math.pi * b) * v)
            for a in steps
            for b in steps
        ]
    return [centre + (2.0 * a - 1.0) * u + (2.0 * b - 1.0) * v for a in steps for b in steps]


def _fan(corners: Reals) -> list[tuple[Reals, Reals]]:
    """The polygon's triangles without their first corner, which all share."""
    return [(corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]


def _vector(values: Reals) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
