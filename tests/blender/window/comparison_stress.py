"""Inside Blender's window: an artist who does everything at once while a comparison runs.

Arguments: the extension zip, or `control`: the same Blender doing the same without the add-on.
"""

from __future__ import annotations

import functools
import math
import sys
import threading
from pathlib import Path
from typing import Any

import bpy
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))
from in_window import (
    Step,
    choose,
    comparison_over,
    install_from,
    module,
    open_example,
    operate,
    play,
    resident_mb,
    show_tab,
    viewport_of,
)

CONTROL = sys.argv[-1] == "control"
OURS = "BLENDER_WORKBENCH" if CONTROL else "PENUMBRA"
SCENES = ("courtyard", "desk", "plaza")
ROUNDS = 6  # each scene twice
VIEWS = 34
CHANGES = 2
BORDER = 0.4  # of the viewport, which is enough to look at


def running() -> bool:
    current = module("comparison.running").current()
    return current is not None and current.state == "running"


def redraw(what: str = "DRAW_WIN_SWAP") -> None:
    operate(bpy.ops.wm.redraw_timer, type=what, iterations=1)


def measured(step: Step) -> Step:
    """Notes how much memory there is after it."""

    @functools.wraps(step)
    def play_and_measure(answer: dict[str, Any]) -> object:
        outcome = step(answer)
        answer.setdefault("after", []).append([step.__name__, round(resident_mb())])
        return outcome

    return play_and_measure


def open_file(number: int) -> Step:
    step = open_example(SCENES[number % len(SCENES)])

    def opened(answer: dict[str, Any]) -> None:
        # The files' own engine is EEVEE; in a rendered viewport it would take 1.4 GB at once, and hide what is ours.
        viewport_of()[1].shading.type = "SOLID"
        step(answer)
        answer.setdefault("threads", []).append(
            sum(thread.name == "Penumbra comparison" for thread in threading.enumerate())
        )

    return opened


def compare(answer: dict[str, Any]) -> None:
    """More than a round takes."""
    scene = bpy.context.scene
    scene.render.engine = OURS
    if CONTROL:
        return
    scene.penumbra_comparison.scale, scene.penumbra.reference_error = 100, 0.002
    scene.penumbra.pixel_samples = 1
    choose("shadow_map", "ray_traced")
    scene.penumbra.settings.ray_traced.rays = 65536
    operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT")


def orbit(answer: dict[str, Any]) -> None:
    _, space, view = viewport_of()
    space.show_region_ui = True
    space.overlay.show_overlays = space.show_gizmo = False
    space.use_render_border = True
    space.render_border_min_x = space.render_border_min_y = 0.0
    space.render_border_max_x = space.render_border_max_y = BORDER
    space.shading.type = "RENDERED"
    view.view_perspective = "PERSP"
    for number in range(VIEWS):
        view.view_rotation = Quaternion((0, 0, 1), number * math.tau / VIEWS) @ Quaternion((1, 0, 0), 1.1)
        redraw("DRAW")
    answer["views"] = answer.get("views", 0) + VIEWS


def add_undo_delete(answer: dict[str, Any]) -> None:
    if not CONTROL:
        show_tab(viewport_of()[0])
    for number in range(CHANGES):
        operate(bpy.ops.mesh.primitive_monkey_add, "EXEC_DEFAULT", True, location=(number, 0, 1))
        operate(bpy.ops.object.light_add, "EXEC_DEFAULT", True, type="AREA", location=(number, 0, 4))
        redraw()
        operate(bpy.ops.ed.undo)
        redraw()
        operate(bpy.ops.object.delete, "EXEC_DEFAULT", True)
        redraw()


def switch_engines(answer: dict[str, Any]) -> None:
    for engine in ("BLENDER_WORKBENCH", "CYCLES", OURS):
        bpy.context.scene.render.engine = engine
        redraw()
    if not CONTROL:
        answer.setdefault("went_on", []).append(running())


def measure(answer: dict[str, Any]) -> None:
    answer.setdefault("resident_mb", []).append(resident_mb())


def compare_small(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    choose("shadow_map", "ray_traced")
    kept.scale, kept.timing_seconds, bpy.context.scene.penumbra.reference_error = 10, 0.05, 0.05
    operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT")


def end(answer: dict[str, Any]) -> None:
    answer["rows"] = [row.status for row in bpy.context.scene.penumbra_comparison.rows]


if __name__ == "__main__":
    rounds = [
        step
        for number in range(ROUNDS)
        for step in (*map(measured, (open_file(number), compare, orbit, add_undo_delete, switch_engines)), measure)
    ]
    if CONTROL:
        play(*rounds)
    else:
        play(install_from(sys.argv[-1]), *rounds, open_file(0), compare_small, comparison_over, end)
