"""What the overlay shows: two techniques, the truth or an error side by side, and the numbers behind each pixel.

Knows the core, not Blender.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import images
from ..records import Image, Mask, Settings
from .worker import Desk, Question

if TYPE_CHECKING:
    from ..bridge import SceneExport

REFERENCE = "REFERENCE"
ERROR = "ERROR"
ERROR_OTHER = "ERROR_OTHER"

_PENDING = 0.05  # grey where the truth is still being traced


@dataclass(frozen=True)
class Wanted:
    """What the overlay is to show."""

    techniques: tuple[str, str]  # A and B
    settings: dict[str, Settings]
    left: str  # a technique's id, REFERENCE, ERROR (of A) or ERROR_OTHER (of B)
    right: str
    light: str = ""  # "" for all lights
    shaded: bool = True  # a picture, else V as grey
    error_scale: float = 0.5
    reference_error: float = 0.02

    @property
    def needs_reference(self) -> bool:
        return any(side in (REFERENCE, ERROR, ERROR_OTHER) for side in (self.left, self.right))


@dataclass(frozen=True)
class Compared:
    """One answer of the overlay's thread. Rows start at the bottom."""

    number: int
    key: Hashable
    left: Image  # (h, w, 4) float32, linear, 0 .. 1: what stands on the screen
    right: Image
    visibility: tuple[Image, Image]  # V of A and B, product over the lights
    reference: Image | None  # V, product over the lights; None until it is traced
    mask: Mask  # where V is asked
    titles: tuple[str, str]
    notes: list[str] = field(default_factory=list)

    def at(self, u: float, v: float) -> dict[str, float]:
        """Figures at a place of the picture, 0 .. 1 from its lower left corner; empty where V is not asked."""
        height, width = self.mask.shape
        column, row = int(u * width), int(v * height)
        if not (0 <= column < width and 0 <= row < height) or not self.mask[row, column]:
            return {}
        figures = {"A": float(self.visibility[0][row, column]), "B": float(self.visibility[1][row, column])}
        if self.reference is not None:
            truth = float(self.reference[row, column])
            figures |= {"truth": truth, "A - truth": figures["A"] - truth, "B - truth": figures["B"] - truth}
        return figures


class Comparisons:
    """Of one viewport."""

    def __init__(self) -> None:
        self._number = 0

    def question(
        self,
        key: Hashable,
        export: SceneExport,
        camera: Callable[[tuple[int, int]], Any],
        size: tuple[int, int],
        wanted: Wanted,
        titles: dict[str, str],
        *,
        smaller: int = 2,
        device: str = "",
        view_by: str = "",
    ) -> Question[Compared]:
        """As pictures.Pictures.question(). @param titles of techniques, by id"""

        def work(renderer: Any, desk: Desk[Compared]) -> None:
            if smaller > 1:
                self._answer(renderer, desk, key, export, camera, _divided(size, smaller), wanted, titles, last=False)
            self._answer(renderer, desk, key, export, camera, size, wanted, titles, last=True)

        return Question(key, work, device, view_by)

    def _answer(
        self,
        renderer: Any,
        desk: Desk[Compared],
        key: Hashable,
        export: SceneExport,
        camera: Callable[[tuple[int, int]], Any],
        size: tuple[int, int],
        wanted: Wanted,
        titles: dict[str, str],
        *,
        last: bool,
    ) -> None:
        export.scene.camera = camera(size)
        renderer.set_scene(export.scene)
        seen = _Seen(renderer, export, wanted, desk)
        desk.show(self._compared(key, seen, wanted, titles, None))
        if last and wanted.needs_reference:
            desk.show(self._compared(key, seen, wanted, titles, seen.truth()))

    def _compared(
        self, key: Hashable, seen: _Seen, wanted: Wanted, titles: dict[str, str], truth: list[Image] | None
    ) -> Compared:
        self._number += 1
        return Compared(
            number=self._number,
            key=key,
            left=seen.side(wanted.left, truth),
            right=seen.side(wanted.right, truth),
            visibility=(_product(seen.visibility[0]), _product(seen.visibility[1])),
            reference=_product(truth) if truth is not None else None,
            mask=seen.mask,
            titles=(_title(wanted.left, wanted, titles), _title(wanted.right, wanted, titles)),
            notes=seen.notes,
        )


class _Seen:
    """All that is known of one view, but for the truth."""

    def __init__(self, renderer: Any, export: SceneExport, wanted: Wanted, desk: Desk[Compared]) -> None:
        self._renderer = renderer
        self._wanted = wanted
        self._desk = desk
        self.notes: list[str] = []
        view = renderer.view()
        self._hit = np.asarray(view.instance) >= 0
        self._albedo = np.asarray(view.albedo)
        self._lights = [i for i, name in enumerate(export.lights) if wanted.light in ("", name)]
        shape = self._hit.shape
        self.mask: Mask = np.zeros(shape, np.uint8)
        self._irradiance: list[Image] = []
        self.visibility: tuple[list[Image], list[Image]] = ([], [])
        one = np.ones(shape, np.float32)
        if not self._lights:
            self.visibility[0].append(one)
            self.visibility[1].append(one)
            self._irradiance.append(np.zeros((*shape, 3), np.float32))
        for index in self._lights:
            desk.stop_if_old()
            self.mask |= np.asarray(renderer.mask(index))
            self._irradiance.append(np.asarray(renderer.irradiance(index)))
            for technique, images_of in zip(wanted.techniques, self.visibility, strict=True):
                images_of.append(self._visibility(index, export.lights[index], technique, one))
        self._white = images.white_level(np.sum(self._irradiance, axis=0))

    def _visibility(self, index: int, light: str, technique: str, one: Image) -> Image:
        reason = str(self._renderer.supports(index, technique))
        if reason:
            self.notes.append(f'"{light}" casts no shadow with {technique}: {reason}')
            return one
        settings = self._wanted.settings.get(technique, {})
        answer = self._renderer.visibility(
            index, technique, settings, statistics=False, progress=self._desk.progress(), reuse=True
        )
        return np.asarray(answer["visibility"])

    def truth(self) -> list[Image]:
        traced = []
        for index in self._lights:
            answer = self._renderer.reference(
                index, standard_error=self._wanted.reference_error, progress=self._desk.progress()
            )
            traced.append(np.asarray(answer["area"]))
        return traced or [np.ones(self._hit.shape, np.float32)]

    def side(self, what: str, truth: list[Image] | None) -> Image:
        """(h, w, 4) linear light of one side, premultiplied."""
        a, b = self.visibility
        if what in (ERROR, ERROR_OTHER):
            if truth is None:
                return self._pending()
            error = _product(a if what == ERROR else b) - _product(truth)
            return _opaque(images.false_colour(error, self.mask, self._wanted.error_scale))
        if what == REFERENCE:
            return self._pending() if truth is None else self._picture(truth)
        return self._picture(a if what == self._wanted.techniques[0] else b)

    def _picture(self, visibility: list[Image]) -> Image:
        if not self._wanted.shaded:
            # V itself as the display value: 0.5 is middle grey, as in the report.
            grey = np.rint(np.where(self._hit, _product(visibility), 0.0) * 255.0).astype(np.uint8)
            return _opaque(np.repeat(grey[..., None], 3, axis=2))
        light = np.full((*self._hit.shape, 3), images.ambient_of(self._white), np.float32)
        for irradiance, seen in zip(self._irradiance, visibility, strict=True):
            light += irradiance * seen[..., None]
        light *= self._albedo
        light /= np.float32(self._white)
        picture = np.empty((*self._hit.shape, 4), np.float32)
        picture[..., :3] = np.minimum(light, 1.0) * self._hit[..., None]
        picture[..., 3] = self._hit  # Blender's own background stays
        return picture

    def _pending(self) -> Image:
        waiting = np.full((*self._hit.shape, 4), _PENDING, np.float32)
        waiting[..., 3] = 1.0
        return waiting


def _opaque(pixels: images.Bytes) -> Image:
    """Of 8-bit sRGB, as linear light."""
    made = np.ones((*pixels.shape[:2], 4), np.float32)
    made[..., :3] = images.linear_table()[pixels]
    return made


def _product(visibility: list[Image]) -> Image:
    product: Image = np.prod(visibility, axis=0, dtype=np.float32)
    return product


def _divided(size: tuple[int, int], smaller: int) -> tuple[int, int]:
    return max(1, -(-size[0] // smaller)), max(1, -(-size[1] // smaller))


def _title(what: str, wanted: Wanted, titles: dict[str, str]) -> str:
    a, b = (titles.get(technique, technique) for technique in wanted.techniques)
    return {REFERENCE: "Truth", ERROR: f"Error of {a}", ERROR_OTHER: f"Error of {b}"}.get(what) or titles.get(
        what, what
    )
