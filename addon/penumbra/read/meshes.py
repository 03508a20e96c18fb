"""Triangles out of an evaluated Blender mesh, in bulk: no Python loop over vertices.

Timings are for a million triangles on two cores.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import compat

FloatArray = npt.NDArray[np.float32]
IndexArray = npt.NDArray[np.int32]


@dataclass
class MeshArrays:
    """Triangles of one evaluated mesh in its own space, as the core takes them."""

    positions: FloatArray  # (n, 3)
    triangles: npt.NDArray[np.uint32]  # (m, 3)
    corner_normals: FloatArray | None = None  # (3 m, 3)
    triangle_material: npt.NDArray[np.uint16] | None = None  # (m,)

    @property
    def finite(self) -> bool:
        # min and max carry a NaN through, and cost less than an isfinite array.
        return bool(np.isfinite(self.positions.min()) and np.isfinite(self.positions.max()))


def triangle_corners_slow(mesh: Any) -> IndexArray:
    """Corner indices of all triangles, flat, by the documented way (150 ms for a million triangles)."""
    corners = np.empty(len(mesh.loop_triangles) * 3, dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    return corners


def triangle_corners_fast(mesh: Any) -> IndexArray | None:
    """The same through the address of the first triangle (1 ms), or None where the memory is not what we expect.

    Blender keeps three int32 per triangle, one triangle after the other. That is no promise of its API, so the stride
    is measured and some triangles are compared with what the API says; all of them are compared in the tests.
    """
    loop_triangles = mesh.loop_triangles
    count = len(loop_triangles)
    if count < 2:
        return None
    address = loop_triangles[0].as_pointer()
    stride = 3 * ctypes.sizeof(ctypes.c_int32)
    if loop_triangles[count - 1].as_pointer() - address != stride * (count - 1):
        return None
    shared = np.ctypeslib.as_array((ctypes.c_int32 * (3 * count)).from_address(address))
    corners: IndexArray = shared.copy()
    if corners.min() < 0 or corners.max() >= len(mesh.loops):
        return None
    for i in {0, 1, count // 3, count // 2, (2 * count) // 3, count - 1}:
        if tuple(loop_triangles[i].loops) != tuple(corners[3 * i : 3 * i + 3]):
            return None
    return corners


def _read_attribute(
    mesh: Any, name: str, key: str, fallback: tuple[Any, str], shape: int, dtype: type
) -> npt.NDArray[Any]:
    """A whole attribute by its internal name (1 ms), or by the documented way where the name is unknown (20 ms+)."""
    attribute = mesh.attributes.get(name)
    source, field_name = (attribute.data, key) if attribute is not None else fallback
    values: npt.NDArray[Any] = np.empty(len(source) * shape, dtype=dtype)
    source.foreach_get(field_name, values)
    return values


def read_mesh(mesh: Any, *, fast: bool = True) -> MeshArrays | None:
    """All triangles of an evaluated mesh, or None if it has none. fast=False takes the documented ways only."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners = triangle_corners_fast(mesh) if fast else None
    if corners is None:
        corners = triangle_corners_slow(mesh)

    if fast:
        positions = _read_attribute(mesh, "position", "vector", (mesh.vertices, "co"), 3, np.float32)
        corner_vertex = _read_attribute(mesh, ".corner_vert", "value", (mesh.loops, "vertex_index"), 1, np.int32)
    else:
        positions = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
        mesh.vertices.foreach_get("co", positions)
        corner_vertex = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get("vertex_index", corner_vertex)
    triangles = np.take(corner_vertex, corners).reshape(-1, 3).view(np.uint32)

    normals: FloatArray | None = None
    if compat.has_smooth_normals(mesh):
        per_corner = np.empty(len(mesh.loops) * 3, dtype=np.float32)
        mesh.corner_normals.foreach_get("vector", per_corner)
        normals = np.take(per_corner.reshape(-1, 3), corners, axis=0)

    material: npt.NDArray[np.uint16] | None = None
    if mesh.attributes.get("material_index") is not None:
        per_face = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.attributes["material_index"].data.foreach_get("value", per_face)
        if per_face.any():
            face = np.empty(count, dtype=np.int32)
            mesh.loop_triangle_polygons.foreach_get("value", face)
            material = np.take(per_face, face).clip(0, 65535).astype(np.uint16)
    return MeshArrays(positions.reshape(-1, 3), triangles, normals, material)
