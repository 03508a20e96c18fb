"""The passes that a view layer delivers: one list, for Blender's sockets and for what is written into them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from . import catalogue

COMBINED = "Combined"
_LONGEST_NAME = 63  # bytes; Blender cuts what is longer


@dataclass(frozen=True, slots=True)
class Pass:
    name: str
    what: Literal["visibility", "reference", "error"]
    technique: str = ""  # "" for the reference
    light: str = ""  # "" for the product of all lights


def pass_list(view_layer: Any, lights: Sequence[str]) -> Iterator[Pass]:
    """Penumbra's own passes of a view layer, in the order of their sockets. Pure: Blender asks at any time.

    lights: names of the lights that may have passes of their own
    """
    taken: set[str] = set()
    for entry in _wanted(view_layer.penumbra, lights):
        yield replace(entry, name=_free(entry.name, taken))


def _wanted(chosen: Any, lights: Sequence[str]) -> Iterator[Pass]:
    techniques = [info for info in catalogue.techniques() if info["id"] in chosen.visibility]
    for light in lights if chosen.per_light else ("",):
        behind = f" {light}" if light else ""
        if chosen.use_reference:
            yield Pass(f"Reference{behind}", "reference", "", light)
        for info in techniques:
            yield Pass(f"Visibility {info['title']}{behind}", "visibility", info["id"], light)
        for info in techniques if chosen.use_error else ():
            yield Pass(f"Error {info['title']}{behind}", "error", info["id"], light)


def _free(name: str, taken: set[str]) -> str:
    """The name as Blender can keep it, numbered where it is cut to one that another pass has."""
    number = 1
    while True:
        ending = f" {number}" if number > 1 else ""
        kept = name.encode()[: _LONGEST_NAME - len(ending)].decode("utf-8", "ignore") + ending
        if kept not in taken:
            taken.add(kept)
            return kept
        number += 1


def light_names(scene: Any) -> list[str]:
    """Lights that a render of the scene may hold, by their objects' names, without evaluating anything."""
    return sorted(obj.name for obj in scene.objects if obj.type == "LIGHT" and not obj.hide_render)
