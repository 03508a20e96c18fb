"""Renders cases with techniques and measures what must hold. One process, which may crash or hang: see run.py."""

from __future__ import annotations

import contextlib
import math
import resource
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import native
from . import limits, properties
from .border import not_refused
from .cases import EVERY_PICTURE, Case, Check
from .closed_forms import FORMS, told
from .ground import Ground
from .lamps import shrunk
from .properties import Image, Mask
from .rows import Measured
from .setups import Setup, under

# Steps of the quality settings that are swept: (setting, values). Small enough for a picture of 96 x 72.
SWEEPS: Mapping[str, Mapping[str, tuple[str, tuple[int, ...]]]] = {
    "samples": {
        "light_samples": ("samples", (4, 16, 64, 256)),
        "ray_traced": ("rays", (4, 16, 64, 256)),
        "masked_rays": ("rays", (128, 256, 512, 1024)),
        "linear_light_maps": ("samples", (2, 3, 5, 9, 17)),
    },
    "maps": {
        "shadow_map": ("map_size", (64, 128, 256, 512)),
        "hybrid": ("map_size", (64, 128, 256, 512)),
        "pcf": ("map_size", (64, 128, 256, 512)),
        "smoothies": ("map_size", (64, 128, 256, 512)),
        "penumbra_maps": ("map_size", (64, 128, 256, 512)),
        "plateaus": ("map_size", (64, 128, 256, 512)),
        "linear_light_maps": ("map_size", (64, 128, 256, 512)),
        "light_samples": ("map_size", (64, 128, 256, 512)),
    },
}

REFERENCE_ERROR = 0.004
NEVER = -math.inf
"""No figure of what is asked instead makes the property hold: it is off, by the limit's reason."""
EDGE_PIXELS = 0.004
"""Share of the pixels at which an edge may fall within rounding: see cases.SAME."""


@dataclass
class Pictures:
    """What a technique made of a case."""

    images: list[Image]
    masks: list[Mask]
    surfaces: list[npt.NDArray[np.int64]]  # what each pixel sees: the number of the instance, in all frames the same
    moving: list[set[int]]  # instances that stand elsewhere in the next frame
    truth: Callable[[int], Image]
    hard: Callable[[], Image]  # the truth of the first frame's first light without extent
    memory_mb: list[float]  # in use after each image
    costs: Sequence[float] = ()  # of the images, in a sweep
    warnings: list[str] = field(default_factory=list)


def _last(pictures: Pictures) -> tuple[Image, Image, Mask]:
    last = len(pictures.images) - 1
    return pictures.images[last], pictures.truth(last), pictures.masks[last]


def _same_image(pictures: Pictures) -> float:
    first = pictures.images[0]
    common = [pictures.masks[0] & mask for mask in pictures.masks[1:]]
    return max(properties.rms_difference(first, *pair) for pair in zip(pictures.images[1:], common, strict=True))


def _same_mask(pictures: Pictures) -> float:
    return max(properties.mask_changed(pictures.masks[0], mask) for mask in pictures.masks[1:])


def _truths(pictures: Pictures) -> list[Image]:
    return [pictures.truth(i) for i in range(len(pictures.images))]


def _steady(pictures: Pictures) -> list[Mask]:
    frames = pairwise(zip(pictures.masks, pictures.surfaces, strict=True))
    return [
        ((a != 0) & (b != 0) & (seen == then) & ~np.isin(seen, list(moving))).astype(np.uint8)
        for ((a, seen), (b, then)), moving in zip(frames, pictures.moving, strict=True)
    ]


def _moving(before: Setup, after: Setup) -> set[int]:
    pairs = zip(before.parts, after.parts, strict=False)
    return {i for i, (a, b) in enumerate(pairs) if not np.array_equal(a.world_from_local(), b.world_from_local())}


def _converges(pictures: Pictures) -> float:
    truth, mask = pictures.truth(0), pictures.masks[0]
    return properties.rate(pictures.costs, [properties.error(image, truth, mask) for image in pictures.images])


MEASURES: Mapping[str, Callable[[Pictures], float]] = {
    "finite": lambda pictures: properties.not_finite(pictures.images),
    "in 0 to 1": lambda pictures: properties.out_of_range(pictures.images),
    "penumbra": lambda pictures: properties.penumbra_error(*_last(pictures)),
    "picture": lambda pictures: properties.error(*_last(pictures)),
    "umbra and light": lambda pictures: properties.wrong_elsewhere(*_last(pictures)),
    "same image": _same_image,
    "same mask": _same_mask,
    "monotone": lambda pictures: properties.wrong_way(pictures.images, pictures.hard(), pictures.masks[0]),
    "no popping": lambda pictures: properties.pops(pictures.images, _truths(pictures), _steady(pictures)),
    "even steps": lambda pictures: properties.unevenness(pictures.images, _steady(pictures)),
    "no leak": lambda pictures: properties.grown(pictures.memory_mb),
    "converges": _converges,
}


def resident_mb() -> float:
    """Memory that the process has in use; 0 where the system does not tell."""
    with contextlib.suppress(OSError, IndexError, ValueError):
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1048576.0
    return 0.0


class Bench:
    """A renderer, and the truth of the case at work: the techniques share it."""

    def __init__(self, core: Any, device: str = "", view_by: str = "") -> None:
        self.core = core
        self.renderer = native.renderer(core, device, view_by)
        self._case = ""
        self._frames: Sequence[Setup] = ()
        self._scenes: list[Any] = []
        self._truths: dict[int, Image] = {}
        self._hard: Image | None = None
        self._ground: Ground | None = None

    def measure(self, case: Case, technique: str) -> tuple[list[Measured], list[str]]:
        """What must hold, as figures; and what the plan warns of. Empty where the case does not ask the technique."""
        if case.build is None:
            return [Measured("refused", float(len(not_refused(self.core, self.renderer, technique))), 0.0)], []
        if case.sweep and technique not in SWEEPS[case.sweep]:
            return [], []
        self._begin(case)
        started = time.perf_counter()
        pictures = self._pictures(case, technique)
        seconds = time.perf_counter() - started
        found = [self._measured(case, technique, check, pictures) for check in (*EVERY_PICTURE, *case.checks)]
        return [*found, Measured("ends", seconds, case.ends_s)], pictures.warnings

    def _begin(self, case: Case) -> None:
        if case.id == self._case or case.build is None:
            return
        self._frames = case.build()
        self._scenes = [frame.scene(self.core) for frame in self._frames]
        self._truths, self._hard, self._ground = {}, None, None
        self._case = case.id

    def _pictures(self, case: Case, technique: str) -> Pictures:
        runs: list[tuple[int, dict[str, Any]]] = [(i, {}) for i in range(len(self._frames))]
        costs: Sequence[float] = ()
        if case.sweep:
            setting, costs = SWEEPS[case.sweep][technique]
            runs = [(0, {setting: value}) for value in costs]
        images, masks, surfaces, memory_mb = [], [], [], []
        warnings: dict[str, None] = {}
        for frame, settings in runs:
            self.renderer.set_scene(self._scenes[frame])
            light = self._frames[frame].light
            made = self.renderer.visibility(light, technique, settings, statistics=False)
            images.append(np.array(made["visibility"]))
            masks.append(np.array(self.renderer.mask(light)))
            surfaces.append(np.array(self.renderer.view().instance, np.int64))
            memory_mb.append(resident_mb())
            warnings |= dict.fromkeys(warning["reason"] for warning in made.get("warnings", ()))
        return Pictures(
            images,
            masks,
            surfaces,
            [_moving(a, b) for a, b in pairwise(self._frames)],
            lambda frame: self._truth(case, 0 if case.sweep else frame),
            lambda: self._hard_shadow(),
            memory_mb,
            costs,
            list(warnings),
        )

    def _measured(self, case: Case, technique: str, check: Check, pictures: Pictures) -> Measured:
        """The figure, and where the case's bound is not held, how far the closed forms go. If it is above all of them
        that say anything of it, the whole picture is asked instead; if they say nothing of that either, its pixels."""
        value = MEASURES[check.property](pictures)
        named = limits.forms_of(technique, case.id, check.property) if value > check.bound else []
        if not named:
            return Measured(check.property, value, check.bound)
        ground = self._case_ground(pictures)
        forms = {name: FORMS[name](ground, technique) for name in named}
        bounds, empty = told(forms, check.property, ground)
        if not empty or any(value <= bound for bound in bounds.values()):
            return Measured(check.property, value, check.bound, bounds)
        value = MEASURES["picture"](pictures)
        bounds, empty = told(forms, "picture", ground)
        if not empty or any(value <= bound for bound in bounds.values()):
            return Measured("picture", value, NEVER, bounds)
        outside = {name: allowed.outside(pictures.images[-1], ground) for name, allowed in forms.items()}
        as_said = {name: EDGE_PIXELS for name, share in outside.items() if share <= EDGE_PIXELS}
        return Measured("own form", min(outside.values()), NEVER, as_said)

    def _case_ground(self, pictures: Pictures) -> Ground:
        """Of the last frame, whose figures the closed forms bound."""
        if self._ground is None:
            frame = self._frames[-1]
            truth = pictures.truth(len(self._frames) - 1)
            self.renderer.set_scene(self._scenes[-1])
            self._ground = Ground(frame, self.renderer.view(), pictures.masks[-1], truth, self._reference)
        return self._ground

    def _reference(self, frame: Setup, exact: bool) -> Image:
        self.renderer.set_scene(frame.scene(self.core))
        answer = self.renderer.reference(frame.light, standard_error=REFERENCE_ERROR, exact=exact)
        return np.array(answer["area"])

    def _truth(self, case: Case, frame: int) -> Image:
        if frame not in self._truths:
            self._truths[frame] = self._reference(self._frames[frame], case.truth == "exact")
        return self._truths[frame]

    def _hard_shadow(self) -> Image:
        """V of the first frame's light, shrunk to its centre."""
        if self._hard is None:
            frame = self._frames[0]
            bare = under(frame, shrunk(frame.lamps[frame.light], 0.0))
            self._hard = self._reference(replace(bare, light=0), False)
        return self._hard
