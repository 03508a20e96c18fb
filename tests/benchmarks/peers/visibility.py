"""From a renderer's picture to V, and the pixels over which all are compared."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]

# Half a degree. Facets of round things are edges too: filters a pixel wide and denoisers mix their shading, and what
# is compared is the shadow. What is left are the flat receivers.
SAME_SURFACE_COS = 0.99996
OFF_PLANE = 0.3  # of the distance between two pixels' points
DARK = 1e-3  # of the largest unshadowed irradiance: what is less is not divided by


def visibility(irradiance: Image, unshadowed: Image) -> Image:
    """V (h, w): what arrives over what would without casters; 1 where nothing would."""
    lit = unshadowed > 0
    return np.where(lit, irradiance / np.where(lit, unshadowed, 1), 1).astype(np.float32)


def inside_surfaces(instance: npt.NDArray[np.int32], normal: Image, position: Image) -> Mask:
    """True where the 3 x 3 pixels around see one surface, so that no geometric edge passes through.

    @param instance (h, w), below 0 where nothing is seen; normal (h, w, 3), unit; position (h, w, 3), finite
    """
    height, width = instance.shape
    one = np.zeros((height, width), bool)
    centre = (slice(1, -1), slice(1, -1))
    one[centre] = instance[centre] >= 0
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            there = (slice(1 + dy, height - 1 + dy), slice(1 + dx, width - 1 + dx))
            step = position[there].astype(np.float64) - position[centre]
            off = np.abs((step * normal[centre]).sum(axis=-1))
            one[centre] &= instance[there] == instance[centre]
            one[centre] &= (normal[there] * normal[centre]).sum(axis=-1) >= SAME_SURFACE_COS
            one[centre] &= off <= OFF_PLANE * np.linalg.norm(step, axis=-1) + 1e-12
    return one


def whole_light_above(light: Any, position_ws: npt.NDArray[np.float64], normal: Image) -> Mask:
    """True where the receiver's plane has all of the light (exchange.Light) on its lit side.

    Where it cuts the light, shares of its area and of its irradiance are different questions (docs/truth.md).
    """

    def along(vector: Any) -> npt.NDArray[np.float64]:
        result: npt.NDArray[np.float64] = normal.astype(np.float64) @ np.asarray(vector, np.float64)
        return result

    if light.kind == "sun":
        return -along(light.direction) > math.sin(light.sun_angle_rad / 2)
    height = along(light.position) - (normal * position_ws).sum(axis=-1)
    u, v = along(light.half_u), along(light.half_v)
    reach = np.abs(u) + np.abs(v) if light.kind == "rectangle" else np.hypot(u, v)
    return height > reach


def bright_enough(unshadowed: Image) -> Mask:
    return unshadowed > DARK * float(unshadowed.max(initial=0.0))
