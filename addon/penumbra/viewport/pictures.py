"""The render engine's pictures in a viewport: small while something moves, then full, then smoother and smoother."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import passes, picture
from ..records import Image
from .worker import Desk, Question

if TYPE_CHECKING:
    from ..bridge import SceneExport

LARGEST_HALF = 65504.0
"""Blender keeps viewport pixels as half floats; what is larger would become infinite, and infinite becomes black."""

_SWIFT_S = 0.06  # a full picture that takes no longer needs no small one before it


@dataclass(frozen=True)
class Shown:
    """A picture that is ready to be put up."""

    number: int  # grows with every picture
    key: Hashable
    pixels: Image  # (h, w, 4) float32, contiguous, finite, no larger than half floats hold; row 0 at the bottom
    size: tuple[int, int]  # w and h of `pixels`
    samples: int
    seconds: float  # in the core
    notes: list[str] = field(default_factory=list)


class Pictures:
    """Of one viewport. Remembers from one picture to the next whether this viewport needs small ones at all."""

    def __init__(self) -> None:
        self._swift = False
        self._number = 0

    def question(
        self,
        key: Hashable,
        export: SceneExport,
        camera: Callable[[tuple[int, int]], Any],
        size: tuple[int, int],
        wanted: picture.Wanted,
        *,
        smaller: int = 2,
        device: str = "",
        view_by: str = "",
    ) -> Question[Shown]:
        """What a viewport wants to see.

        export: its scene belongs to the question: nobody else may change it
        camera: size in pixels -> core.Camera
        smaller: divides the size while something moves
        """

        def paint(renderer: Any, desk: Desk[Shown], size: tuple[int, int], samples: int) -> float:
            """@returns seconds of the first sample"""
            export.scene.camera = camera(size)
            painter = picture.Painter(renderer, export, wanted, desk.progress())
            first = 0.0
            for number in range(samples):
                desk.stop_if_old()
                started = time.perf_counter()
                made = painter.sample(number)
                seconds = time.perf_counter() - started
                first = first or seconds
                self._number += 1
                pixels = displayable(made.planes[passes.COMBINED])
                notes = list(dict.fromkeys(made.notes + made.warnings))
                desk.show(Shown(self._number, key, pixels, size, made.samples, seconds, notes))
            return first

        def work(renderer: Any, desk: Desk[Shown]) -> None:
            if not self._swift and smaller > 1:
                width, height = (max(1, -(-edge // smaller)) for edge in size)
                paint(renderer, desk, (width, height), 1)
            self._swift = False  # unless the picture gets ready now
            self._swift = paint(renderer, desk, size, wanted.pixel_samples) < _SWIFT_S

        return Question(key, work, device, view_by)


def displayable(colour: Image) -> Image:
    """A copy without NaN and without what half floats cannot hold."""
    pixels = np.nan_to_num(colour, nan=0.0, posinf=LARGEST_HALF, neginf=0.0)
    np.clip(pixels, -LARGEST_HALF, LARGEST_HALF, out=pixels)
    return np.ascontiguousarray(pixels, np.float32)
