"""Inside Blender's window: an artist who does everything at once while a comparison runs.

Arguments: the extension zip.
"""

from __future__ import annotations

import gc
import math
import sys
import threading
from pathlib import Path
from typing import Any

import bpy
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))
from comparison_panel import install, module, operate, viewport, window
from in_window import NOT_YET, play

SCENES = ("courtyard", "desk", "plaza")
ROUNDS = 4
VIEWS = 50


def resident_mb() -> float:
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20


def running() -> bool:
    current = module("comparison.running").current()
    return current is not None and current.state == "running"


def redraw(what: str = "DRAW_WIN_SWAP") -> None:
    operate(bpy.ops.wm.redraw_timer, type=what, iterations=1)


def open_file(number: int) -> Any:
    def step(answer: dict[str, Any]) -> None:
        bpy.ops.wm.open_mainfile(filepath=f"/penumbra/examples/{SCENES[number % len(SCENES)]}.blend", load_ui=False)
        answer.setdefault("threads", []).append(
            sum(thread.name == "Penumbra comparison" for thread in threading.enumerate())
        )

    return step


def choose(*techniques: str) -> None:
    chosen = bpy.context.scene.penumbra_comparison.techniques
    for info in module("catalogue").techniques():
        setattr(chosen, info["id"], info["id"] in techniques)


def compare(answer: dict[str, Any]) -> None:
    """More than a round takes."""
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    scene.penumbra_comparison.scale, scene.penumbra.reference_error = 100, 0.002
    scene.penumbra.pixel_samples = 1
    choose("shadow_map", "ray_traced")
    scene.penumbra.settings.ray_traced.rays = 65536
    operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT")


def orbit(answer: dict[str, Any]) -> None:
    area, _ = viewport()
    area.spaces.active.show_region_ui = True
    area.spaces.active.shading.type = "RENDERED"
    view = area.spaces.active.region_3d
    view.view_perspective = "PERSP"
    for number in range(VIEWS):
        view.view_rotation = Quaternion((0, 0, 1), number * math.tau / VIEWS) @ Quaternion((1, 0, 0), 1.1)
        redraw("DRAW")
    answer["views"] = answer.get("views", 0) + VIEWS


def change(answer: dict[str, Any]) -> None:
    for number in range(3):
        operate(bpy.ops.mesh.primitive_monkey_add, "EXEC_DEFAULT", True, location=(number, 0, 1))
        operate(bpy.ops.object.light_add, "EXEC_DEFAULT", True, type="AREA", location=(number, 0, 4))
        redraw()
        operate(bpy.ops.ed.undo)
        redraw()
        operate(bpy.ops.object.delete, "EXEC_DEFAULT", True)
        redraw()
    for engine in ("BLENDER_WORKBENCH", "CYCLES", "PENUMBRA"):
        bpy.context.scene.render.engine = engine
        redraw()
    answer.setdefault("went_on", []).append(running())


def measure(answer: dict[str, Any]) -> None:
    answer.setdefault("resident_mb", []).append(resident_mb())


def compare_small(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    choose("shadow_map", "ray_traced")
    kept.scale, kept.timing_seconds, bpy.context.scene.penumbra.reference_error = 10, 0.05, 0.05
    operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT")


def wait(answer: dict[str, Any]) -> object:
    return NOT_YET if module("comparison.running").current() is not None else None


def end(answer: dict[str, Any]) -> None:
    answer["rows"] = [row.status for row in bpy.context.scene.penumbra_comparison.rows]
    answer["size"] = [window().width, window().height]


if __name__ == "__main__":
    rounds = [step for number in range(ROUNDS) for step in (open_file(number), compare, orbit, change, measure)]
    play(install, *rounds, open_file(0), compare_small, wait, end, pause_s=0.5)
