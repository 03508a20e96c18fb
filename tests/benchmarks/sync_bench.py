"""How long it takes until the next picture may be drawn after one thing changed in a large scene, part by part.

    python tests/benchmarks/sync_bench.py [--objects N] [--triangles N] [--runs N] [--json FILE]

What changes: one of the objects moves; a light moves; one mesh is edited; nothing (the view alone). The parts are those
of a viewport: `read` is SceneSync.update(), `question` the copies that the viewport's thread gets, `core` is
Renderer.set_scene(), after which the picture may be drawn. Blender's own evaluation and the drawing stand beside them,
in no sum. Milliseconds by the wall clock: the median of the runs, and in brackets the least, which a busy machine
disturbs least.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import penumbra_core
from penumbra.sync import SceneSync

PARTS = ("read", "question", "core")
SIZE_PX = (96, 54)


def furnish(objects: int, triangles: int) -> None:
    """A field of balls, each a mesh of its own, on a floor, with a square light, a sun and a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    side = math.ceil(math.sqrt(objects))
    rings = max(3, round(math.sqrt(triangles / 2)))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=rings, ring_count=rings, radius=0.3)
    ball = bpy.context.object
    for number in range(1, objects):
        other = ball.copy()
        other.data = ball.data.copy()
        other.location = (number % side, number // side, 0.4)
        scene.collection.objects.link(other)
    bpy.ops.mesh.primitive_plane_add(size=4 * side)
    bpy.ops.object.light_add(type="AREA", location=(side / 2, side / 2, 8))
    bpy.ops.object.light_add(type="SUN", rotation=(0.5, 0.3, 0))
    bpy.ops.object.camera_add(location=(side / 2, -side / 2, side), rotation=(0.8, 0, 0))
    scene.camera = bpy.context.object
    scene.render.resolution_x, scene.render.resolution_y = SIZE_PX
    bpy.context.view_layer.update()


def move_an_object(run: int) -> None:
    bpy.data.objects["Sphere"].location.z = 0.5 + 0.01 * run


def move_a_light(run: int) -> None:
    bpy.data.objects["Area"].location.x += 0.01 * (run % 7 - 3)


def edit_a_mesh(run: int) -> None:
    mesh = bpy.data.objects["Sphere"].data
    mesh.vertices[0].co.z = 0.3 + 0.001 * run
    mesh.update()


CHANGES: dict[str, Callable[[int], None]] = {
    "one object moves": move_an_object,
    "a light moves": move_a_light,
    "one mesh is edited": edit_a_mesh,
    "nothing but the view": lambda run: None,
}


class Viewport:
    """What a viewport of the engine does with a change, its thread's work done in turn."""

    def __init__(self) -> None:
        self.sync = SceneSync()
        self.renderer = penumbra_core.Renderer()
        self.sync.update(bpy.context.evaluated_depsgraph_get())
        self.times: dict[str, float] = {}

    def follow(self, change: Callable[[], None]) -> dict[str, float]:
        """Milliseconds of each part."""
        times: dict[str, float] = {}

        def timed(part: str, action: Callable[[], Any]) -> Any:
            started = time.perf_counter()
            result = action()
            times[part] = (time.perf_counter() - started) * 1e3
            return result

        def read(_scene: Any, depsgraph: Any) -> None:
            timed("read", lambda: self.sync.update(depsgraph))

        # Blender tells what it updated only while it updates.
        bpy.app.handlers.depsgraph_update_post.append(read)
        try:
            change()
            timed("Blender", bpy.context.view_layer.update)
        finally:
            bpy.app.handlers.depsgraph_update_post.remove(read)
        if "read" not in times:
            timed("read", lambda: self.sync.update(bpy.context.evaluated_depsgraph_get()))
        else:
            times["Blender"] -= times["read"]

        def question() -> Any:
            points = self.sync.box_points
            assert points is not None
            assert self.sync.export is not None
            return self.sync.export.scene.copy()

        scene = timed("question", question)
        timed("core", lambda: self.renderer.set_scene(scene))
        timed("drawing", lambda: self.renderer.visibility(0, "shadow_map", {"map_size": 256}, statistics=False))
        return times


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--objects", type=int, default=1000)
    parser.add_argument("--triangles", type=int, default=200, help="of each object")
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args(arguments)
    furnish(options.objects, options.triangles)
    viewport = Viewport()
    viewport.follow(lambda: None)
    export = viewport.sync.export
    assert export is not None
    print(
        f"{export.objects} objects, {export.triangles} triangles, {export.meshes} meshes, {len(export.lights)} lights"
    )
    columns = [*PARTS, "sum", "Blender", "drawing"]
    print(f"{'milliseconds, median (least)':30}" + "".join(f"{name:>16}" for name in columns))
    told: dict[str, dict[str, list[float]]] = {}
    for name, change in CHANGES.items():
        runs = []
        for number in range(options.runs):
            times = viewport.follow(lambda change=change, number=number: change(number))  # type: ignore[misc]
            runs.append(times | {"sum": sum(times[part] for part in PARTS)})
        told[name] = {part: [run[part] for run in runs] for part in columns}
        cells = []
        for part in columns:
            values = told[name][part]
            cells.append(f"{statistics.median(values):.2f} ({min(values):.2f})")
        print(f"{name:30}" + "".join(f"{cell:>16}" for cell in cells))
    if options.json:
        options.json.write_text(json.dumps({"objects": export.objects, "milliseconds": told}), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
