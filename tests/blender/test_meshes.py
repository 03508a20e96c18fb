"""The fast way through Blender's memory gives the same numbers as the documented one."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest
from blender_kit import Kit, Sent, bpy
from penumbra.read import meshes


def checksum(values: Any) -> int:
    return zlib.crc32(np.ascontiguousarray(values).tobytes())


def evaluated(obj: Any) -> Any:
    bpy.context.view_layer.update()
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def mixed_mesh(kit: Kit) -> Any:
    """Triangles, quads and a concave pentagon, two materials, one smooth face."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0.5), (2, 2, 0), (1.5, 0.4, 0), (0.5, 0.5, 2)]
    obj = kit.mesh("Mixed", points, [(0, 1, 2, 3), (1, 4, 6, 5, 2), (0, 3, 7)])
    for colour in ("A", "B"):
        obj.data.materials.append(bpy.data.materials.new(colour))
    obj.data.polygons[1].material_index = 1
    obj.data.polygons[2].use_smooth = True
    return obj


def subdivided(kit: Kit) -> Any:
    obj = mixed_mesh(kit)
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = 5
    return obj


@pytest.mark.parametrize("make", [mixed_mesh, subdivided])
def test_the_fast_path_has_the_checksum_of_the_slow_path(kit: Kit, make: Any) -> None:
    mesh = evaluated(make(kit))
    fast, slow = meshes.read_mesh(mesh), meshes.read_mesh(mesh, fast=False)
    assert fast is not None and slow is not None
    for name in ("positions", "triangles", "corner_normals", "triangle_material"):
        assert checksum(getattr(fast, name)) == checksum(getattr(slow, name)), name


@pytest.mark.parametrize("make", [mixed_mesh, subdivided])
def test_the_pointer_to_the_triangles_is_understood_by_this_blender(kit: Kit, make: Any) -> None:
    mesh = evaluated(make(kit))
    mesh.calc_loop_triangles()
    fast = meshes.triangle_corners_fast(mesh)
    assert fast is not None
    assert checksum(fast) == checksum(meshes.triangle_corners_slow(mesh))


def test_a_foreign_memory_layout_falls_back_to_the_slow_path() -> None:
    class Triangle:
        def __init__(self, address: int) -> None:
            self.address = address

        def as_pointer(self) -> int:
            return self.address

    class Mesh:
        loop_triangles = tuple(Triangle(1000 + 16 * i) for i in range(5))  # four words each, not three

    assert meshes.triangle_corners_fast(Mesh()) is None


def test_numbers_equal_a_plain_loop_over_blenders_triangles(kit: Kit) -> None:
    mesh = evaluated(mixed_mesh(kit))
    mesh.calc_loop_triangles()
    arrays = meshes.read_mesh(mesh)
    assert arrays is not None and arrays.corner_normals is not None and arrays.triangle_material is not None
    for i, triangle in enumerate(mesh.loop_triangles):
        assert tuple(arrays.triangles[i]) == tuple(triangle.vertices)
        assert arrays.triangle_material[i] == triangle.material_index
        for k, loop in enumerate(triangle.loops):
            np.testing.assert_array_equal(arrays.corner_normals[3 * i + k], mesh.corner_normals[loop].vector)
    np.testing.assert_array_equal(arrays.positions, [v.co for v in mesh.vertices])


def test_flat_shading_sends_no_normals_and_one_smooth_face_sends_them(kit: Kit) -> None:
    cube = kit.cube()
    flat = meshes.read_mesh(evaluated(cube))
    cube.data.polygons[3].use_smooth = True
    cube.data.update()
    smooth = meshes.read_mesh(evaluated(cube))
    assert flat is not None and flat.corner_normals is None
    assert smooth is not None and smooth.corner_normals is not None


def test_custom_normals_are_sent(kit: Kit) -> None:
    plane = kit.plane()
    plane.data.polygons[0].use_smooth = True
    slanted = np.array([0.6, 0.0, 0.8])
    plane.data.normals_split_custom_set([tuple(slanted)] * 4)
    arrays = meshes.read_mesh(evaluated(plane))
    assert arrays is not None and arrays.corner_normals is not None
    np.testing.assert_allclose(arrays.corner_normals, np.tile(slanted, (6, 1)), atol=2e-3)


def test_one_material_sends_no_indices(kit: Kit) -> None:
    arrays = meshes.read_mesh(evaluated(kit.cube()))
    assert arrays is not None and arrays.triangle_material is None


def test_a_mesh_of_edges_only_has_no_triangles(kit: Kit) -> None:
    mesh = bpy.data.meshes.new("Wire")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    assert meshes.read_mesh(mesh) is None


def test_a_single_triangle_is_read(kit: Kit) -> None:
    arrays = meshes.read_mesh(evaluated(kit.mesh("T", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])))
    assert arrays is not None
    assert arrays.triangles.tolist() == [[0, 1, 2]]


def test_a_million_triangles_arrive_whole(kit: Kit, sent: Sent) -> None:
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708, size=2)
    export = kit.read()
    assert export.triangles == 2 * 708 * 708
    mesh = sent.meshes[0]
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(4.0, rel=1e-5)
