"""Puts pictures and words up in a 3D viewport. The one file that uses `gpu`, and only while Blender asks to draw."""

from __future__ import annotations

from typing import Any

import numpy as np

from .records import Image

Box = tuple[int, int, int, int]  # left, bottom, width, height in pixels of the region


class Texture:
    """A picture on Blender's device, sent when it changes."""

    def __init__(self) -> None:
        self._number = -1
        self._texture: Any = None

    def update(self, number: int, pixels: Image) -> bool:
        """@returns True if it was sent. @param number another one for other pixels"""
        if number == self._number and self._texture is not None:
            return False
        import gpu

        # Blender takes any memory for float32 and reads on past its end: make sure of it here.
        assert pixels.dtype == np.float32 and pixels.flags.c_contiguous and pixels.shape[2] == 4
        height, width = pixels.shape[:2]
        data = gpu.types.Buffer("FLOAT", pixels.size, pixels.reshape(-1))
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
        self._number = number
        return True

    def draw(self, box: Box) -> None:
        """Scene-linear pixels, stretched over the box; Blender's view transform follows."""
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if self._texture is None:
            return
        left, bottom, width, height = box
        gpu.state.blend_set("ALPHA_PREMULT")
        draw_texture_2d(self._texture, (left, bottom), width, height)
        gpu.state.blend_set("NONE")

    def free(self) -> None:
        self._texture = None
        self._number = -1


def draw_text(lines: list[str], left: float, top: float, *, size: float = 13.0, alarm: bool = False) -> None:
    """Words with a shadow behind them, so that they can be read on any picture."""
    import blf

    font = 0
    blf.size(font, size)
    blf.enable(font, blf.SHADOW)
    blf.shadow(font, 3, 0.0, 0.0, 0.0, 0.8)
    blf.shadow_offset(font, 1, -1)
    blf.color(font, 1.0, 0.6 if alarm else 1.0, 0.5 if alarm else 1.0, 1.0)
    y = top
    for line in lines:
        y -= 1.4 * size
        blf.position(font, left, y, 0.0)
        blf.draw(font, line)
    blf.disable(font, blf.SHADOW)
