"""What must hold, as functions of images: each gives a number that is 0 where it holds exactly, and grows with the
damage. An image is V (height, width) float32; the truth likewise; the mask is 1 where V is asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.float32]
Mask = npt.NDArray[np.uint8]

VISIBLE_STEP = 0.02
"""A change of V that is told from rounding: five steps of an 8-bit picture."""
MARGIN_PX = 2
"""So far from a border of the truth a pixel is well inside umbra or light."""
PURE = 1e-4
"""Below it, and as far below 1, the truth is umbra and lit: core.measure_errors draws the line there."""


def not_finite(images: Sequence[Image]) -> float:
    """Values that are NaN or infinite, counted."""
    return float(sum(int((~np.isfinite(image)).sum()) for image in images))


def out_of_range(images: Sequence[Image]) -> float:
    """How far the farthest value lies outside of 0 .. 1; infinite for one that is no number."""
    worst = 0.0
    for image in images:
        if image.size:
            if not np.isfinite(image).all():
                return math.inf
            worst = max(worst, float(-image.min()), float(image.max()) - 1.0)
    return max(worst, 0.0)


def rms_difference(a: Image, b: Image, mask: Mask) -> float:
    """Root mean square of a - b over the mask; 0 where nothing is asked."""
    inside = mask != 0
    if not inside.any():
        return 0.0
    return float(np.sqrt(np.mean((a[inside].astype(np.float64) - b[inside]) ** 2)))


def share_changed(a: Image, b: Image, mask: Mask) -> float:
    """Share of the mask in which a and b differ visibly."""
    inside = mask != 0
    if not inside.any():
        return 0.0
    return float(np.mean(~(np.abs(a[inside] - b[inside]) <= VISIBLE_STEP)))


def mask_changed(a: Mask, b: Mask) -> float:
    """Share of pixels that are asked in one image and not in the other."""
    return float(np.mean((a != 0) != (b != 0)))


def in_penumbra(truth: Image, mask: Mask) -> npt.NDArray[np.bool_]:
    return np.asarray((mask != 0) & (truth > PURE) & (truth < 1.0 - PURE))


def away_from_edges(truth: Image, mask: Mask, margin_px: int) -> npt.NDArray[np.bool_]:
    """Pixels of the mask around which, as far as the margin, all is umbra, or all is lit."""
    asked = mask != 0
    umbra = asked & (truth <= PURE)
    lit = asked & (truth >= 1.0 - PURE)
    return np.asarray(_eroded(umbra, margin_px) | _eroded(lit, margin_px))


def penumbra_error(image: Image, truth: Image, mask: Mask) -> float:
    """RMSE over the truth's penumbra; 0 where there is none."""
    inside = in_penumbra(truth, mask)
    return rms_difference(image, truth, inside.astype(np.uint8))


def error(image: Image, truth: Image, mask: Mask) -> float:
    """RMSE over the mask."""
    return rms_difference(image, truth, mask)


def wrong_elsewhere(image: Image, truth: Image, mask: Mask, margin_px: int = MARGIN_PX) -> float:
    """Share of the pixels well inside umbra and light that are visibly wrong."""
    return share_changed(image, truth, away_from_edges(truth, mask, margin_px).astype(np.uint8))


def wrong_way(images: Sequence[Image], hard: Image, mask: Mask) -> float:
    """V of a growing light: where its centre is seen V may only fall, where it is hidden only rise. RMS of what goes
    the other way, in the worst step.
    """
    inside = mask != 0
    sign = np.where(hard[inside] > 0.5, 1.0, -1.0)
    worst = 0.0
    for before, after in pairwise(images):
        rise = sign * (after[inside].astype(np.float64) - before[inside])
        if rise.size:
            worst = max(worst, float(np.sqrt(np.mean(np.maximum(rise, 0.0) ** 2))))
    return worst


def rate(costs: Sequence[float], errors: Sequence[float], floor: float = 1e-5) -> float:
    """Slope of log error against log cost by least squares: -0.5 for plain random sampling. Errors below the floor are
    rounding; a series that begins there has converged, with -infinity."""
    if errors[0] <= floor:
        return -math.inf
    x = np.log(np.asarray(costs, np.float64))
    y = np.log(np.maximum(np.asarray(errors, np.float64), floor))
    x -= x.mean()
    return float((x * (y - y.mean())).sum() / (x * x).sum())


def pops(images: Sequence[Image], truths: Sequence[Image], steady: Sequence[Mask], margin_px: int = MARGIN_PX) -> float:
    """Share of the pixels, in the worst step of an animation, that change visibly though they stay umbra or stay lit
    and no shadow's border is near.

    steady: for each step, 1 where both frames ask for V and see the same surface.
    """
    worst = 0.0
    for i, (before, after) in enumerate(pairwise(truths)):
        calm = away_from_edges(before, steady[i], margin_px) & away_from_edges(after, steady[i], margin_px)
        calm &= np.abs(before - after) <= PURE
        worst = max(worst, share_changed(images[i], images[i + 1], calm.astype(np.uint8)))
    return worst


def unevenness(images: Sequence[Image], steady: Sequence[Mask]) -> float:
    """The largest step of an animation (RMS change between two frames) over the median one: a steady motion has about
    1. Steps no larger than that of a single pixel from 0 to 1 count as such a one. steady: as for pops()."""
    steps = [
        max(rms_difference(a, b, mask), 1.0 / math.sqrt(max(1, int(mask.sum()))))
        for (a, b), mask in zip(pairwise(images), steady, strict=True)
    ]
    return max(steps) / float(np.median(steps))


def grown(in_use: Sequence[float]) -> float:
    """What stays in use, of figures after each of equal frames: the least of their last third over that of the second.
    What one frame still holds when it is counted is gone in another."""
    third = max(1, len(in_use) // 3)
    return min(in_use[-third:]) - min(in_use[-2 * third : -third] or in_use)


def _eroded(inside: npt.NDArray[np.bool_], margin_px: int) -> npt.NDArray[np.bool_]:
    """Pixels all of whose neighbours within the margin are inside; the picture goes on beyond its border."""
    rows, columns = inside.shape
    padded = np.pad(inside, margin_px, mode="edge")
    result = np.ones_like(inside)
    for dy in range(2 * margin_px + 1):
        for dx in range(2 * margin_px + 1):
            result &= padded[dy : dy + rows, dx : dx + columns]
    return result
