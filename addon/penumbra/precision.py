"""How well an error figure is known."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .records import Image, Mask

_CLEAR = 1e-4  # from here to one minus this lies the penumbra (cpp/src/measure/classes.h)


def headline_error(pictures: Sequence[Image], reference: Image, standard_error: Image, mask: Mask) -> float:
    """Standard error of the headline figure, an RMSE over the pixels of the reference's penumbra, or over all without.

    Three things blur the mean square error: seeds (the variance of each pixel's square error over them, pixels being
    independent), the reference's own noise, which is as often up as down, and the squares of that noise, which are
    counted as error and are not. Derivation: docs/measuring.md.

    @param pictures one per seed; a value that is not finite counts as an error of 1, as everywhere
    @return 0 for an empty mask
    """
    inside = mask != 0
    penumbra = inside & (reference > _CLEAR) & (reference < 1.0 - _CLEAR)
    chosen = penumbra if penumbra.any() else inside
    n = int(chosen.sum())
    if n == 0:
        return 0.0
    errors = np.stack([_errors(picture[chosen], reference[chosen]) for picture in pictures])
    squares = errors * errors
    noise = standard_error[chosen].astype(np.float64) ** 2
    of_seeds = float(squares.var(axis=0, ddof=1).sum()) / (len(pictures) * n * n) if len(pictures) > 1 else 0.0
    of_reference = 4.0 * float((errors.mean(axis=0) ** 2 * noise).sum()) / (n * n)
    blur = math.sqrt(of_seeds + of_reference + float(noise.mean()) ** 2)
    rmse = math.sqrt(float(squares.mean()))
    # d sqrt(x) = dx / (2 sqrt(x)), and never more than sqrt(dx).
    return min(blur / (2.0 * rmse), math.sqrt(blur)) if rmse > 0.0 else math.sqrt(blur)


def _errors(values: Image, truth: Image) -> npt.NDArray[np.float64]:
    difference = values.astype(np.float64) - truth
    return np.where(np.isfinite(difference), difference, 1.0)
