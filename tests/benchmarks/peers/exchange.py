"""A scene as all renderers get it: world-space float32 triangles, one light, one camera."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float32]
Triangles = npt.NDArray[np.uint32]
Triple = tuple[float, float, float]

SCENE_FILE, SOUP_FILE = "scene.npz", "scene.bin"
SOUP_MAGIC = 0x50454552  # "PEER"
LIGHT_KINDS = ("rectangle", "ellipse", "sun")


@dataclass(frozen=True)
class Light:
    """Lengths in metres; half_u and half_v span an area light, direction is where it shines."""

    kind: str  # of LIGHT_KINDS
    position: Triple
    direction: Triple
    half_u: Triple
    half_v: Triple
    sun_angle_rad: float
    power: float  # as Blender has it: watts, of a sun W/m2


@dataclass(frozen=True)
class Camera:
    """Looks along its local -z, +y up; square pixels, no shift."""

    world_from_camera: list[list[float]]
    tan_half_width: float
    near_m: float
    far_m: float
    width_px: int
    height_px: int


@dataclass(frozen=True)
class Part:
    """One object."""

    name: str
    positions: Points  # (n, 3), world
    triangles: Triangles  # (m, 3)


@dataclass(frozen=True)
class SharedScene:
    name: str
    parts: list[Part]
    light: Light
    camera: Camera

    @property
    def triangle_count(self) -> int:
        return sum(len(part.triangles) for part in self.parts)

    def soup(self) -> tuple[Points, Triangles]:
        """All parts as one mesh."""
        offsets = np.cumsum([0, *(len(part.positions) for part in self.parts[:-1])])
        triangles = [part.triangles + np.uint32(offset) for part, offset in zip(self.parts, offsets, strict=True)]
        return np.concatenate([part.positions for part in self.parts]), np.concatenate(triangles)

    def save(self, folder: Path) -> None:
        """scene.npz for the Python workers, scene.bin for the C++ one."""
        folder.mkdir(parents=True, exist_ok=True)
        facts = {"name": self.name, "light": asdict(self.light), "camera": asdict(self.camera)}
        arrays: dict[str, Any] = {"facts": json.dumps(facts), "names": [part.name for part in self.parts]}
        for i, part in enumerate(self.parts):
            arrays[f"positions_{i}"], arrays[f"triangles_{i}"] = part.positions, part.triangles
        self._save_soup(folder / SOUP_FILE)
        partial = folder / f"partial_{SCENE_FILE}"
        np.savez(partial, **arrays)
        partial.replace(folder / SCENE_FILE)

    def _save_soup(self, path: Path) -> None:
        """Little-endian: magic, width, height, light kind, vertices, triangles (uint32); world_from_camera by rows,
        tan_half_width, position, direction, half_u, half_v, sun angle (float64); positions (float32); indices (uint32).
        """
        positions, triangles = self.soup()
        head = (SOUP_MAGIC, self.camera.width_px, self.camera.height_px, LIGHT_KINDS.index(self.light.kind))
        light = (*self.light.position, *self.light.direction, *self.light.half_u, *self.light.half_v)
        numbers = [*np.ravel(self.camera.world_from_camera), self.camera.tan_half_width, *light]
        with open(path, "wb") as file:
            file.write(np.array([*head, len(positions), len(triangles)], "<u4").tobytes())
            file.write(np.array([*numbers, self.light.sun_angle_rad], "<f8").tobytes())
            file.write(positions.astype("<f4").tobytes())
            file.write(triangles.astype("<u4").tobytes())


def load(folder: Path) -> SharedScene:
    with np.load(folder / SCENE_FILE, allow_pickle=False) as arrays:
        facts = json.loads(str(arrays["facts"]))
        parts = [
            Part(str(name), arrays[f"positions_{i}"], arrays[f"triangles_{i}"])
            for i, name in enumerate(arrays["names"])
        ]
    light = Light(**{key: tuple(value) if isinstance(value, list) else value for key, value in facts["light"].items()})
    return SharedScene(facts["name"], parts, light, Camera(**facts["camera"]))
