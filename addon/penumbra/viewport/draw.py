"""Puts pictures and words up in a 3D viewport. The one file that uses `gpu`, and only while Blender asks to draw."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .. import compat
from ..records import Image

Box = tuple[int, int, int, int]  # left, bottom, width, height in pixels of the region
Colour = tuple[float, float, float, float]


def free_px(context: Any) -> tuple[int, int]:
    """Left and right end of what neither sidebar nor toolbar covers, in pixels of the region."""
    region = context.region
    left, right = 0, int(region.width)
    for other in context.area.regions:
        if other.type not in ("UI", "TOOLS") or other.width <= 1:  # one pixel: hidden
            continue
        if other.alignment == "LEFT":
            left = max(left, other.x + other.width - region.x)
        elif other.alignment == "RIGHT":
            right = min(right, other.x - region.x)
    return left, max(right, left)


class Texture:
    """A picture on Blender's device, sent when it changes."""

    def __init__(self) -> None:
        self.number = -1  # of the pixels that are there
        self._texture: Any = None

    def update(self, number: int, pixels: Image) -> bool:
        """@returns True if it was sent. @param number another one for other pixels"""
        if number == self.number and self._texture is not None:
            return False
        import gpu

        # Blender takes any memory for float32 and reads on past its end: make sure of it here.
        assert pixels.dtype == np.float32 and pixels.flags.c_contiguous and pixels.shape[2] == 4
        height, width = pixels.shape[:2]
        data = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
        self.number = number
        return True

    def draw(self, box: Box, *, on_display: bool = False) -> None:
        """Linear pixels, stretched over the box. In an engine's drawing Blender's view transform follows; `on_display`:
        in a handler's, which draws on what is shown, they become sRGB.
        """
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if self._texture is None:
            return
        left, bottom, width, height = box
        gpu.state.blend_set("ALPHA_PREMULT")
        to_srgb = compat.texture_to_srgb() if on_display else {}
        draw_texture_2d(self._texture, (left, bottom), width, height, **to_srgb)
        gpu.state.blend_set("NONE")

    def free(self) -> None:
        self._texture = None
        self.number = -1


def draw_text(
    lines: list[str], left: float, top: float, *, size: float = 13.0, alarm: bool = False, right: bool = False
) -> None:
    """Words on a dark ground, so that they can be read on any picture; `right`: they end at `left`."""
    import blf

    if not lines:
        return
    font = 0
    blf.size(font, size)
    width = max(blf.dimensions(font, line)[0] for line in lines)
    height = 1.4 * size * len(lines)
    start = left - width if right else left
    draw_bar(start - 6.0, top - height - 6.0, width + 12.0, height + 6.0, (0.0, 0.0, 0.0, 1.0))
    blf.color(font, 1.0, 0.6 if alarm else 1.0, 0.5 if alarm else 1.0, 1.0)
    y = top
    for line in lines:
        y -= 1.4 * size
        blf.position(font, left - (blf.dimensions(font, line)[0] if right else 0.0), y, 0.0)
        blf.draw(font, line)


def draw_bar(left: float, bottom: float, width: float, height: float, colour: Colour) -> None:
    """A filled rectangle in pixels of the region; display colour."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    right, top = left + width, bottom + height
    corners = ((left, bottom), (right, bottom), (left, top), (right, top))
    batch = batch_for_shader(shader, "TRI_STRIP", {"pos": corners})
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def draw_ramp(left: float, bottom: float, width: float, height: float, colours: Sequence[Colour]) -> None:
    """A bar that takes these display colours one after the other, from left to right."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    step = width / (len(colours) - 1)
    corners = [(left + i * step, y) for i in range(len(colours)) for y in (bottom, bottom + height)]
    each = [colour for colour in colours for _ in range(2)]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch_for_shader(shader, "TRI_STRIP", {"pos": corners, "color": each}).draw(shader)


@contextlib.contextmanager
def scissored(region: Any, left: int, bottom: int, width: int, height: int) -> Iterator[None]:
    """Nothing is drawn outside of this part of the region."""
    import gpu

    before = gpu.state.scissor_get()
    gpu.state.scissor_test_set(True)
    gpu.state.scissor_set(before[0] + left, before[1] + bottom, max(width, 0), max(height, 0))
    try:
        yield
    finally:
        gpu.state.scissor_set(*before)
