"""Shadows as textures: V of one light on flat surfaces, with the place and the UVs to lay them over a scene."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import images
from .errors import UserError
from .files import slug, write_bytes
from .progress import Progress
from .records import Image, Settings

if TYPE_CHECKING:
    from .bridge import SceneExport

UVS = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
"""Of the four corners of every baked texture, in their order."""

Corners = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, slots=True)
class Texture:
    """V on one surface; row 0 is the bottom row, along the corners 0 and 1."""

    light: str
    surface: str
    visibility: Image  # (h, w), 0 umbra .. 1 lit
    corners: Corners  # world, metres, at UVS


def bake(
    renderer: Any, export: SceneExport, technique: str, settings: Settings, lights: Sequence[int], progress: Progress
) -> list[Texture]:
    """@raises UserError if no light has a texture to give."""
    progress.stage("view", 1.0)
    renderer.set_scene(export.scene)
    textures: list[Texture] = []
    for index in lights:
        name = export.lights[index]
        progress.stage(f"{name}: {technique}", 2.0)
        if renderer.supports(index, technique):
            continue
        for entry in renderer.bake(index, technique, settings, progress=progress):
            corners = tuple((float(c[0]), float(c[1]), float(c[2])) for c in entry["corners_ws"])
            textures.append(Texture(name, str(entry["name"]), np.asarray(entry["visibility"]), corners))
    if not textures:
        raise UserError(f"{technique} makes no textures for this scene's lights; plateaus bakes the planes it sees")
    return textures


def write(textures: Sequence[Texture], folder: Path, extension: str) -> list[Path]:
    """One image per texture; `planes.json` and `planes.obj` with the quads to show them on.

    Images hold V as it is, not light: load them as Non-Color data and multiply this light's direct light by them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths: list[Path] = []
    names: list[str] = []
    for number, texture in enumerate(textures, 1):
        names.append(f"{number:02}-{slug(texture.light)}-{slug(texture.surface)}{extension}")
        path = folder / names[-1]
        if extension == ".exr":
            images.write_exr(path, {"visibility": texture.visibility})
        else:
            grey = np.rint(np.clip(texture.visibility, 0.0, 1.0) * 255.0).astype(np.uint8)
            write_bytes(path, images.png(grey))
        paths.append(path)
    write_bytes(folder / "planes.json", _json(textures, names).encode())
    write_bytes(folder / "planes.obj", _obj(textures, names).encode())
    write_bytes(folder / "planes.mtl", _mtl(names).encode())
    return [*paths, folder / "planes.json", folder / "planes.obj", folder / "planes.mtl"]


def _json(textures: Sequence[Texture], names: Sequence[str]) -> str:
    entries = [
        {
            "image": name,
            "light": texture.light,
            "surface": texture.surface,
            "size": [int(texture.visibility.shape[1]), int(texture.visibility.shape[0])],
            "corners_m": texture.corners,
            "uvs": UVS,
        }
        for texture, name in zip(textures, names, strict=True)
    ]
    return json.dumps({"schema": 1, "planes": entries}, indent=1) + "\n"


def _obj(textures: Sequence[Texture], names: Sequence[str]) -> str:
    """Quads in Blender's own axes (import with Forward Y, Up Z)."""
    lines = ["# Baked by penumbra: axes as in Blender, import with Forward Y and Up Z", "mtllib planes.mtl"]
    lines += [f"vt {u:g} {v:g}" for u, v in UVS]
    for number, (texture, name) in enumerate(zip(textures, names, strict=True)):
        stem = name.rpartition(".")[0]
        lines += [f"o {stem}", f"usemtl {stem}"]
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in texture.corners]
        lines.append("f " + " ".join(f"{4 * number + i}/{i}" for i in range(1, 5)))
    return "\n".join(lines) + "\n"


def _mtl(names: Sequence[str]) -> str:
    return "".join(f"newmtl {name.rpartition('.')[0]}\nKd 1 1 1\nmap_Kd {name}\n\n" for name in names)
