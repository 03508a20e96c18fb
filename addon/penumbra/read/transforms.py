"""Small helpers on transforms and directions, float64."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

DoubleArray = npt.NDArray[np.float64]


def matrix_of(blender_matrix: Any) -> DoubleArray:
    return np.array(blender_matrix, dtype=np.float64)


def is_singular(world_from_local: DoubleArray) -> bool:
    """True for a transform that is not finite or flattens space, judged apart from its overall scale."""
    linear = world_from_local[:3, :3]
    if not np.isfinite(world_from_local).all():
        return True
    lengths = np.linalg.norm(linear, axis=0)
    if lengths.min() == 0.0:
        return True
    return bool(abs(np.linalg.det(linear / lengths)) < 1e-7)


def unit(vector: DoubleArray) -> DoubleArray | None:
    length = float(np.linalg.norm(vector))
    if not math.isfinite(length) or length == 0.0:
        return None
    return vector / length
