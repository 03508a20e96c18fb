"""Images in and out: float EXR, PNG, false colours, the shaded picture, and the FLIP figure."""

from __future__ import annotations

import functools
import importlib.util
import io
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from . import colours, exr
from .files import write_bytes
from .records import Image, Mask

Bytes = npt.NDArray[np.uint8]

ERROR_SCALE = 0.5
"""End of the false-colour legend of the error PNG, in units of V: the error of a hard shadow edge in a penumbra."""

AMBIENT_SHARE = 0.03
"""Ambient light of the shaded picture, as a share of the irradiance that is shown as white."""


# --- float images ----------------------------------------------------------------------------------------------------


def write_exr(path: Path, channels: Mapping[str, Image], attributes: Mapping[str, str] | None = None) -> None:
    """float32 EXR, ZIP compressed, first row on top: the core's row 0 is the bottom, so the rows are turned over here.

    @param channels each (height, width), by full channel name ("visibility", "normal.X")
    """
    pixels = {name: np.asarray(channel, np.float32)[::-1] for name, channel in channels.items()}
    write_bytes(path, exr.encode(pixels, attributes))


def layer(name: str, image: Image, components: str = "XYZ") -> dict[str, Image]:
    """The channels of one EXR layer: "normal.X", "normal.Y", "normal.Z"."""
    return {f"{name}.{letter}": image[..., i] for i, letter in enumerate(components)}


# --- pictures --------------------------------------------------------------------------------------------------------


def srgb_from_linear(linear: Image) -> Image:
    """The sRGB transfer curve; input is cut to 0 .. 1."""
    x = np.clip(np.asarray(linear, np.float32), 0.0, 1.0)
    return np.where(x <= 0.0031308, x * 12.92, 1.055 * np.power(np.maximum(x, 1e-8), 1 / 2.4) - 0.055).astype(
        np.float32
    )


@functools.cache
def _srgb_table() -> Bytes:
    # 14 bits of linear light are enough for each of the 256 sRGB codes; a table is ten times as fast as the power.
    linear = np.arange(16384, dtype=np.float32) / 16383
    table: Bytes = np.rint(srgb_from_linear(linear) * 255).astype(np.uint8)
    return table


def srgb_bytes(linear: Image) -> Bytes:
    """Linear light 0 .. 1 as 8-bit sRGB."""
    index = (np.clip(linear, 0.0, 1.0) * 16383 + 0.5).astype(np.uint16)
    shown: Bytes = _srgb_table()[index]
    return shown


@functools.cache
def linear_table() -> Image:
    """Linear light of the 256 sRGB codes."""
    x = np.arange(256, dtype=np.float64) / 255.0
    linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


def png(pixels: Bytes) -> bytes:
    """8-bit grey (h, w) or RGB (h, w, 3), row 0 at the bottom, as a PNG file."""
    from PIL import Image as Pillow

    buffer = io.BytesIO()
    # Level 3 is three times as fast as the default 6 and some 5 % larger on shaded pictures.
    Pillow.fromarray(np.ascontiguousarray(pixels[::-1])).save(buffer, "PNG", compress_level=3)
    return buffer.getvalue()


def white_level(irradiance: Image) -> float:
    """The irradiance (W/m^2) shown as white: the 98th percentile of the brightest channel over the lit pixels."""
    brightest = irradiance.max(axis=-1)
    lit = brightest[brightest > 0]
    return float(np.percentile(lit, 98)) if lit.size else 1.0


def ambient_of(white: float) -> float:
    """Ambient irradiance (W/m^2) of a picture with this white level."""
    return AMBIENT_SHARE * white


def shade(irradiance: Image, visibility: Image, albedo: Image, white: float) -> Image:
    """Linear picture of one light, 1 is white: (irradiance x V + ambient) x albedo / white.

    The division by pi of a Lambert surface and the exposure are one factor, chosen so that a white surface under
    `white` W/m^2 is shown as white.
    """
    light = irradiance * visibility[..., None] + ambient_of(white)
    return (light * albedo / white).astype(np.float32)


# --- errors as colours -----------------------------------------------------------------------------------------------


def false_colour(error: Image, mask: Mask, scale: float = ERROR_SCALE) -> Bytes:
    """|error| from black (0) through red to pale yellow (`scale` and more); mid grey outside the mask."""
    index = np.clip(np.abs(error) * (255.0 / scale) + 0.5, 0, 255).astype(np.uint8)
    picture = colours.table("inferno")[index]
    picture[mask == 0] = 64
    return picture


def with_legend(picture: Bytes, title: str, scale: float = ERROR_SCALE) -> Bytes:
    """The picture with its colour legend and title in a strip below; rows bottom up like the input."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    height, width = picture.shape[:2]
    strip = 44
    sheet = Pillow.new("RGB", (max(width, 240), height + strip), (24, 24, 27))
    sheet.paste(Pillow.fromarray(np.ascontiguousarray(picture[::-1])), (0, 0))
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(11)
    bar_left, bar_width, bar_top = 12, min(256, sheet.width - 24), height + 8
    ramp = colours.table("inferno")[np.linspace(0, 255, bar_width).astype(int)]
    sheet.paste(Pillow.fromarray(np.repeat(ramp[None], 10, axis=0)), (bar_left, bar_top))
    labels = [(0.0, "la", "0"), (0.5, "ma", f"{scale / 2:g}"), (1.0, "ra", f"{scale:g}")]
    if sheet.width > bar_width + 80:
        labels[2] = (1.0, "la", f" {scale:g} or more")
    for share, anchor, label in labels:
        below = 13 if anchor != "la" or share == 0.0 else -1  # the long label stands beside the bar
        place = (bar_left + share * (bar_width - 1) + (4 if below < 0 else 0), bar_top + below)
        draw.text(place, label, fill=(212, 212, 216), font=font, anchor=anchor)
    if sheet.width > bar_width + 200:
        draw.text((sheet.width - 12, bar_top + 13), title, fill=(212, 212, 216), font=font, anchor="ra")
    return np.asarray(sheet)[::-1]


# --- FLIP ------------------------------------------------------------------------------------------------------------


def display_grey(visibility: Image) -> Image:
    """The fixed display mapping that FLIP looks at: sRGB(0.05 + 0.75 V), grey, no exposure and no albedo."""
    return srgb_from_linear(0.05 + 0.75 * np.clip(visibility, 0.0, 1.0))


def has_flip() -> bool:
    """False in a Blender whose extension came without the report's libraries."""
    return importlib.util.find_spec("flip_evaluator") is not None


def flip_mean(visibility: Image, reference: Image, mask: Mask) -> float:
    """Mean FLIP over the mask, at FLIP's own viewing conditions (67 pixels per degree); 0 if the mask is empty.

    Outside the mask both images show the same grey, so that nothing there is seen as a difference.
    """
    # Its OpenMP threads would otherwise spin for a while after each call, and steal the time of what is timed next.
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    import flip_evaluator

    inside = mask != 0
    if not inside.any():
        return 0.0
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    # FLIP's filters reach no farther than this many pixels at 67 pixels per degree; beyond, nothing is to be seen.
    margin = 32
    window = np.s_[
        max(rows[0] - margin, 0) : rows[-1] + 1 + margin, max(columns[0] - margin, 0) : columns[-1] + 1 + margin
    ]
    shown = [
        np.repeat(np.where(inside, display_grey(image), np.float32(0.5))[window][..., None], 3, axis=2).astype(
            np.float32
        )
        for image in (reference, visibility)
    ]
    error, _, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(shown[0]), np.ascontiguousarray(shown[1]), "LDR", applyMagma=False, computeMeanError=False
    )
    return float(np.asarray(error).reshape(shown[0].shape[:2])[inside[window]].mean(dtype=np.float64))
