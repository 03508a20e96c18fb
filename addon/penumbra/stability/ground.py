"""What the closed forms look at: the truth of a case, and figures of its geometry for each pixel."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import properties
from .lamps import above_plane, disc_of, ribbon_of, shrunk
from .properties import Image, Mask
from .setups import Lamp, Setup, Vector, under

Reals = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MAP_TEXELS = 1024
"""Of a map's side by default; the coarser of `hybrid` is refined by volumes."""
FINE = 5
FINE_FROM_PX = 20_000
"""Up to so many pixels, edges are sought in a picture FINE times as fine."""
LEVELS = 8
"""Sizes of the light that are tried for lambda."""

Reference = Callable[[Setup, bool], Image]
"""reference(frame, exact): V as it truly is."""


class Ground:
    """Of one frame. Nothing here depends on a technique."""

    def __init__(self, frame: Setup, view: Any, mask: Mask, truth: Image, reference: Reference) -> None:
        self.frame = frame
        self.mask = mask
        self.truth = truth
        self._reference = reference
        self._levels: dict[Lamp, npt.NDArray[np.int64]] = {}
        self._lamp = frame.lamps[frame.light]
        self._normals = np.array(view.normal_ws, np.float64)
        self._instance = np.array(view.instance, np.int64)
        self._positions = np.array(view.position_cr, np.float64) + np.asarray(view.eye_ws, np.float64)

    def _truth_of(self, lamp: Lamp) -> Image:
        frame = under(self.frame, lamp)
        return self._reference(replace(frame, light=0), lamp.kind in ("rectangle", "polygon"))

    @cached_property
    def _fine(self) -> int:
        """Pixels of a finer picture in each pixel, an odd number, so that one of them has the same centre."""
        return FINE if self.texel_px < 1.0 and self.mask.size <= FINE_FROM_PX else 1

    @cached_property
    def _fine_hard(self) -> Flags:
        """The light's centre is not hidden by a caster."""
        fine, eye = self._fine, self.frame.eye
        larger = replace(eye, size_px=(fine * eye.size_px[0], fine * eye.size_px[1]))
        frame = under(replace(self.frame, eye=larger), shrunk(self._lamp, 0.0))
        return np.asarray(self._reference(replace(frame, light=0), False) > 0.5)

    @cached_property
    def under_horizon(self) -> Reals:
        """Share of the light that lies under the surface's own plane."""
        return 1.0 - above_plane(self._lamp, self._positions, self._normals)

    @cached_property
    def centre_seen(self) -> Flags:
        """The centre is hidden neither by a caster nor by the surface's own plane."""
        bare = shrunk(self._lamp, 0.0)
        return self._at_centres(self._fine_hard) & (above_plane(bare, self._positions, self._normals) > 0.5)

    @cached_property
    def in_a_plane(self) -> Flags:
        """The surface is the ground."""
        return np.asarray(self._instance == 0)

    @cached_property
    def _pixel_m(self) -> float:
        """From one pixel to the next on what is seen, in the middle of all; 0 without neighbours."""
        inside = self.mask != 0
        steps = np.linalg.norm(np.diff(self._positions, axis=1), axis=2)[inside[:, 1:] & inside[:, :-1]]
        return float(np.median(steps)) if steps.size else 0.0

    @cached_property
    def _corners(self) -> Reals:
        return np.concatenate([_placed(part) for part in self.frame.parts])

    @cached_property
    def size_m(self) -> float:
        """Of the scene, along its longest axis."""
        return float((self._corners.max(axis=0) - self._corners.min(axis=0)).max())

    @cached_property
    def texel_px(self) -> float:
        """Texels over pixels: of a map that covers the whole scene."""
        return self.size_m / MAP_TEXELS / self._pixel_m if self._pixel_m > 0.0 else 1.0

    @cached_property
    def slope(self) -> Reals:
        """Of the surface against the light's rays: metres of depth over metres across; 0 head-on."""
        lamp = shrunk(self._lamp, 0.0)
        towards = (
            np.broadcast_to(-np.asarray(lamp.direction_ws, np.float64), self._positions.shape)
            if lamp.kind == "sun"
            else np.asarray(lamp.position_ws, np.float64) - self._positions
        )
        length = np.maximum(np.linalg.norm(towards, axis=2), 1e-300)
        cosine = np.clip(np.einsum("ijk,ijk->ij", towards, self._normals) / length, 1e-9, 1.0)
        return np.asarray(np.sqrt(1.0 - cosine * cosine) / cosine)

    def near_shadow(self, roundings: float) -> Flags:
        """Where the shadow of casters may fall that are so many roundings of float32 larger: it grows as the light's
        distance does behind the nearest caster."""
        shadow = (self.truth < 1.0 - properties.PURE) & (self.mask != 0)
        if not self._pixel_m > 0.0 or not math.isfinite(self.depth_ratio):
            return np.ones_like(shadow)
        grown_m = roundings * float(np.finfo(np.float32).eps) * self.size_m * self.depth_ratio
        reach = min(math.ceil(grown_m / self._pixel_m), max(shadow.shape))
        return np.asarray(_filtered(shadow, reach, np.maximum) if reach > 0 else shadow)

    def at_hard_edge(self, texels: float) -> Flags:
        """An edge of the centre's shadow lies within so many texels, or too near to be told from here."""
        reach = min(max(1, math.ceil(texels * self.texel_px * self._fine)), max(self._fine_hard.shape))
        seen = self._fine_hard
        return self._at_centres(_filtered(seen, reach, np.maximum) != _filtered(seen, reach, np.minimum))

    def _at_centres(self, fine: Flags) -> Flags:
        middle = self._fine // 2
        return np.asarray(fine[middle :: self._fine, middle :: self._fine])

    @cached_property
    def depth_ratio(self) -> float:
        """k: the deepest receiver's depth from the light over the nearest caster's, or infinity."""
        lamp = self._lamp
        axis = np.asarray(lamp.direction_ws, np.float64)
        if lamp.kind == "sun":
            return 1.0
        casters = [part for part in self.frame.parts if part.casts and part.name not in ("ground", "second")]
        if not casters or not (self.mask != 0).any():
            return 1.0
        centre = np.asarray(shrunk(lamp, 0.0).position_ws, np.float64)
        depths = [_placed(part) @ axis - centre @ axis for part in casters]
        nearest = min(float(own.min()) for own in depths)
        deepest = max(float((self._positions[self.mask != 0] @ axis - centre @ axis).max()), nearest)
        return deepest / nearest if nearest > 0.0 else math.inf

    def distances(self, gauges: Sequence[str]) -> tuple[Reals, Reals]:
        """Lambda, from least to greatest: the size of a light of this shape and place that the casters just touch, in
        sizes of the light; at most 1. Found by trying LEVELS sizes."""
        known = {"own": self._own_distances, "outline": self._outline_distances, "disc": self._disc_distances}
        found = [known[gauge] for gauge in gauges]
        return np.minimum.reduce([low for low, _ in found]), np.maximum.reduce([high for _, high in found])

    @property
    def _own_distances(self) -> tuple[Reals, Reals]:
        return self._distances_in(self._lamp)

    @property
    def _disc_distances(self) -> tuple[Reals, Reals]:
        towards = np.asarray(self._lamp.direction_ws, np.float64)
        if self._lamp.kind in ("point", "spot"):
            towards = self._middle - np.asarray(self._lamp.position_ws, np.float64)
        disc = disc_of(self._lamp, _vector(towards))
        low, high = self._distances_in(disc)
        # The octagon lies in the disc, and the disc in the octagon 1 / cos 22.5 degrees as large.
        return (low * math.cos(math.pi / 8.0), high) if disc is not self._lamp else (low, high)

    @property
    def _outline_distances(self) -> tuple[Reals, Reals]:
        """A sphere's outline grows as the tangent of the angle that it subtends, the sphere as its sine. A line is
        drawn as a lozenge, which lies in a rectangle."""
        low, high = self._own_distances
        if self._lamp.kind == "line":
            return self._distances_in(ribbon_of(self._lamp))[0], high
        if self._lamp.kind not in ("point", "spot"):
            return low, high
        far = float(np.linalg.norm(self._middle - np.asarray(self._lamp.position_ws, np.float64)))
        sine = min(self._lamp.radius_m / far, 0.999)

        def grown(size: Reals) -> Reals:
            return np.asarray(size * np.sqrt((1.0 - sine * sine) / (1.0 - np.square(size * sine))))

        return grown(low), grown(high)

    @cached_property
    def _middle(self) -> Reals:
        """Of what is seen."""
        inside = self.mask != 0
        return np.asarray(self._positions[inside].mean(axis=0) if inside.any() else np.zeros(3))

    def _distances_in(self, lamp: Lamp) -> tuple[Reals, Reals]:
        if lamp not in self._levels:
            clear = np.zeros(self.truth.shape, np.int64)
            for level in range(1, LEVELS + 1):
                whole = self._truth_of(shrunk(lamp, level / LEVELS)) >= 1.0 - properties.PURE
                clear = np.where(whole & (clear == level - 1), level, clear)
            self._levels[lamp] = clear
        clear = self._levels[lamp]
        return clear / LEVELS, np.minimum(clear + 1, LEVELS) / LEVELS

    def least_around(self, values: Reals) -> Reals:
        """As far as a texel moves a picture: the least of the neighbours in part, as the texel is of a pixel."""
        return self._around(values, np.minimum)

    def greatest_around(self, values: Reals) -> Reals:
        return self._around(values, np.maximum)

    def _around(self, values: Reals, pick: Any) -> Reals:
        # A texel and a half: half a texel of place, one of the bilinear filter.
        reach = 1.5 * self.texel_px
        part = min(1.0, reach)
        return np.asarray((1.0 - part) * values + part * _filtered(values, max(1, math.ceil(reach)), pick))


def _placed(part: Any) -> Reals:
    matrix = part.world_from_local()
    return np.asarray(part.shape[0].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def _vector(values: Reals) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _filtered(values: npt.NDArray[Any], reach_px: int, pick: Any) -> npt.NDArray[Any]:
    """The least or greatest in the square around each pixel; one axis after the other, windows of twice the size from
    two of the half."""
    result = values
    for axis in (0, 1):
        wanted = 2 * reach_px + 1
        result = np.pad(result, [(reach_px, reach_px) if axis == own else (0, 0) for own in (0, 1)], mode="edge")
        window = 1
        while window < wanted:
            step = min(window, wanted - window)
            length = result.shape[axis] - step
            result = pick(np.take(result, range(length), axis), np.take(result, range(step, step + length), axis))
            window += step
    return result
