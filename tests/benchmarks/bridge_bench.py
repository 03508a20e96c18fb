"""How long the bridge takes for a million triangles, part by part.

    python tests/benchmarks/bridge_bench.py [--triangles N] [--runs N]

Prints milliseconds, the median over the runs: by the wall clock, and by the processor, which a busy machine disturbs
less (Blender's own threads count there, too). Every run reads a mesh that Blender has just evaluated anew;
Blender's own work (triangulation, normals) shows as "first touch", since Blender does it when it is first asked.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import bpy
import penumbra_core
from penumbra import bridge
from penumbra.read import meshes


def timed(action: Callable[[], Any]) -> tuple[tuple[float, float], Any]:
    """Milliseconds by the wall clock and by the processor, and the result."""
    wall, processor = time.perf_counter(), time.process_time()
    result = action()
    return ((time.perf_counter() - wall) * 1e3, (time.process_time() - processor) * 1e3), result


def grid(triangles: int, smooth: bool) -> Any:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    side = max(1, round(math.sqrt(triangles / 2)))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=side, y_subdivisions=side)
    if smooth:
        bpy.ops.object.shade_smooth()
    return bpy.context.object


def one_run(obj: Any) -> dict[str, tuple[float, float]]:
    obj.data.vertices[0].co.z += 0.001  # Blender evaluates the mesh anew
    obj.data.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = obj.evaluated_get(depsgraph).data
    times: dict[str, tuple[float, float]] = {}

    def touch() -> None:
        mesh.calc_loop_triangles()
        len(mesh.loop_triangles)
        if mesh.normals_domain != "FACE":
            len(mesh.corner_normals)
            mesh.corner_normals[0].vector.copy()

    times["first touch (Blender)"], _ = timed(touch)
    times["read, fast"], arrays = timed(lambda: meshes.read_mesh(mesh))
    times["read, documented ways"], _ = timed(lambda: meshes.read_mesh(mesh, fast=False))
    times["into the core"], _ = timed(
        lambda: penumbra_core.Mesh(
            "m", arrays.positions, arrays.triangles, corner_normals=arrays.corner_normals, triangle_material=None
        )
    )
    times["read_scene, all of it"], _ = timed(lambda: bridge.read_scene(depsgraph))
    return times


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--runs", type=int, default=7)
    options = parser.parse_args(arguments)
    for smooth in (False, True):
        obj = grid(options.triangles, smooth)
        runs = [one_run(obj) for _ in range(options.runs)]
        print(f"{len(obj.data.polygons) * 2} triangles, {'smooth' if smooth else 'flat'}")
        for part in runs[0]:
            wall, processor = (statistics.median(run[part][k] for run in runs) for k in range(2))
            print(f"  {part:24}{wall:9.1f} ms wall {processor:9.1f} ms processor")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
