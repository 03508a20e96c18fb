"""Colours of an error, without a plotting library: the same in reports, in Blender's panels and in its compositor."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]

STOPS: dict[str, str] = {
    "inferno": (
        "000004 040312 0b0724 150b37 230c4c 310a5c 3e0966 4c0c6b 5a116e 67166e 741a6e 801f6c "
        "8f2469 9b2964 a82e5f b43359 c13a50 cc4248 d74b3f e05536 e9612b ef6e21 f57b17 f8890c "
        "fb9906 fca80d fbb81d f9c72f f5d949 f2e865 f3f586 fcffa4"
    ),
    "RdBu_r": ("053061 2065ab 4393c3 90c4dd d1e5f0 f7f6f6 fddbc7 f3a481 d6604d b1182b 67001f"),
}
"""By name of the colour map, 8-bit sRGB of even stops from 0 to 1. 32 is the most that Blender's colour ramp takes."""


@functools.cache
def stops(name: str) -> Bytes:
    """(n, 3) 8-bit sRGB of a colour map of STOPS."""
    return np.array([list(bytes.fromhex(code)) for code in STOPS[name].split()], np.uint8)


@functools.cache
def table(name: str) -> Bytes:
    """(256, 3) 8-bit sRGB, straight lines between the stops."""
    known = stops(name).astype(np.float64)
    places = np.linspace(0.0, len(known) - 1, 256)
    columns = [np.interp(places, np.arange(len(known)), known[:, i]) for i in range(3)]
    made: Bytes = np.rint(np.stack(columns, axis=1)).astype(np.uint8)
    return made
