"""NaN and infinity at the border of the core: every field of a scene, and every setting, must refuse them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from . import scenes
from .setups import Setup

POISONS = (math.nan, math.inf, -math.inf)
KINDS = ("point", "spot", "sun", "rectangle", "ellipse", "line", "polygon")

Place = tuple[str, Callable[[], object]]
"""A name for people, and what must be refused."""


def not_refused(core: Any, renderer: Any, technique: str) -> list[str]:
    """Places where a value that is no finite number came through, or was refused by other than one sentence."""
    wrong = []
    for name, attempt in places(core, renderer, technique):
        try:
            attempt()
        except core.Error as error:
            if not is_one_sentence(str(error)):
                wrong.append(f"{name}: refused, but says: {error}")
        else:
            wrong.append(f"{name}: accepted")
    return wrong


def is_one_sentence(text: str) -> bool:
    """One line that says something, and what to do: `what is wrong; what to do`."""
    return "\n" not in text.strip() and "; " in text and len(text) < 400


def places(core: Any, renderer: Any, technique: str) -> Iterator[Place]:
    """All fields that hold floating-point numbers, found by asking the classes: a new one is tried by itself."""
    for poison in POISONS:
        for kind in KINDS:
            yield from _fields_of(core, renderer, kind, "light", poison)
        yield from _fields_of(core, renderer, "rectangle", "camera", poison)
        yield from _arrays(core, renderer, poison)
        yield from _settings(core, renderer, technique, poison)
        yield from _options(core, renderer, poison)


def _yard(kind: str) -> Setup:
    return scenes.yard(0.6, kind)


def _fields_of(core: Any, renderer: Any, kind: str, owner: str, poison: float) -> Iterator[Place]:
    def fresh() -> tuple[Any, Any]:
        scene = _yard(kind).scene(core)
        return scene, scene.lights[0] if owner == "light" else scene.camera

    _, example = fresh()
    for name in sorted(name for name in dir(example) if not name.startswith("_")):
        value = getattr(example, name)
        for label, poisoned in _poisonings(value, poison):

            def attempt(name: str = name, poisoned: object = poisoned) -> None:
                scene, changed = fresh()
                setattr(changed, name, poisoned)
                if owner == "light":
                    scene.lights = [changed]
                else:
                    scene.camera = changed
                renderer.set_scene(scene)

            yield f"{kind} {owner}: {name}{label} = {poison}", attempt


def _poisonings(value: object, poison: float) -> Iterator[tuple[str, object]]:
    """The value with one of its numbers replaced, each in turn; nothing for one that holds no floats."""
    if isinstance(value, float):
        yield "", poison
    elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
        for place in np.ndindex(value.shape):
            poisoned = np.array(value)
            poisoned[place] = poison
            yield str(list(place)), poisoned
    elif isinstance(value, list | tuple):
        for i, inner in enumerate(value):
            for label, changed in _poisonings(inner, poison):
                yield f"[{i}]{label}", [*value[:i], changed, *value[i + 1 :]]


def _arrays(core: Any, renderer: Any, poison: float) -> Iterator[Place]:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2]], np.uint32)
    normals = np.tile(np.array([0, 0, 1], np.float32), (3, 1))
    for place in np.ndindex(positions.shape):

        def bad_position(place: tuple[int, ...] = place) -> None:
            changed = positions.copy()
            changed[place] = poison
            core.Mesh("mesh", changed, triangles)

        def bad_normal(place: tuple[int, ...] = place) -> None:
            changed = normals.copy()
            changed[place] = poison
            core.Mesh("mesh", positions, triangles, changed)

        yield f"mesh: positions{list(place)} = {poison}", bad_position
        yield f"mesh: corner_normals{list(place)} = {poison}", bad_normal
    mesh = core.Mesh("mesh", positions, triangles)
    for place in np.ndindex(4, 4):

        def bad_place(place: tuple[int, ...] = place) -> None:
            scene = _yard("rectangle").scene(core)
            matrix = np.eye(4)
            matrix[place] = poison
            scene.add_instance("added", mesh, matrix, np.full((1, 3), 0.8, np.float32))
            renderer.set_scene(scene)

        def bad_move(place: tuple[int, ...] = place) -> None:
            scene = _yard("rectangle").scene(core)
            matrix = np.eye(4)
            matrix[place] = poison
            scene.set_transform(0, matrix)
            renderer.set_scene(scene)

        yield f"instance: world_from_local{list(place)} = {poison}", bad_place
        yield f"scene: set_transform{list(place)} = {poison}", bad_move
    for channel in range(3):

        def bad_albedo(channel: int = channel) -> None:
            scene = _yard("rectangle").scene(core)
            albedo = np.full((1, 3), 0.8, np.float32)
            albedo[0, channel] = poison
            scene.add_instance("added", mesh, np.eye(4), albedo)
            renderer.set_scene(scene)

        yield f"instance: albedo[0, {channel}] = {poison}", bad_albedo


def _settings(core: Any, renderer: Any, technique: str, poison: float) -> Iterator[Place]:
    info = next(info for info in core.techniques() if info["id"] == technique)
    scene = _yard("rectangle").scene(core)
    for setting in info["settings"]:
        if isinstance(setting["default"], bool | str):
            continue

        def attempt(id_: str = setting["id"]) -> None:
            renderer.set_scene(scene)
            renderer.visibility(0, technique, {id_: poison}, statistics=False)

        yield f"{technique}: {setting['id']} = {poison}", attempt


def _options(core: Any, renderer: Any, poison: float) -> Iterator[Place]:
    scene = _yard("rectangle").scene(core)

    def standard_error() -> None:
        renderer.set_scene(scene)
        renderer.reference(0, standard_error=poison)

    def point() -> None:
        core.exact_visibility(scene, 0, np.array([[0.0, poison, 0.0]]), np.array([[0.0, 0.0, 1.0]]))

    def normal() -> None:
        core.exact_visibility(scene, 0, np.zeros((1, 3)), np.array([[poison, 0.0, 1.0]]))

    def seconds() -> None:
        renderer.set_scene(scene)
        renderer.measure(0, [("shadow_map", {})], max_seconds=poison, min_runs=1, max_runs=1)

    yield f"reference: standard_error = {poison}", standard_error
    yield f"exact_visibility: positions = {poison}", point
    yield f"exact_visibility: normals = {poison}", normal
    yield f"measure: max_seconds = {poison}", seconds
