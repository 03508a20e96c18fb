"""Inside Blender's window, for viewport_bench.py: how fast the viewport follows, and what the overlay costs.

Arguments: the extension zip, the number of views.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender" / "window"))
from in_window import (
    OUT,
    in_every_turn,
    install_from,
    module,
    open_example,
    operate,
    overlay_ready,
    play,
    region_of,
    viewport_of,
    viewports_ready,
)

ZIP, VIEWS = sys.argv[-2], int(sys.argv[-1])
SIZE = (960, 540)
ORBIT_S = 5.0
TURN = Quaternion((0, 0, 1), 0.05)


def engine() -> Any:
    (found,) = module("viewport.engine_view").EngineView.alive
    return found


def arrange(answer: dict[str, Any]) -> None:
    """960 x 540 pixels of the viewport, seen from the scene's camera."""
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    scene.penumbra.pixel_samples = 1
    area, space, view = viewport_of()
    space.show_region_ui = space.show_region_toolbar = space.show_gizmo = False
    space.overlay.show_overlays = False
    region = region_of(area)
    assert region.width >= SIZE[0] and region.height >= SIZE[1], (region.width, region.height)
    space.use_render_border = True
    space.render_border_min_x = space.render_border_min_y = 0.0
    space.render_border_max_x, space.render_border_max_y = SIZE[0] / region.width, SIZE[1] / region.height
    view.view_matrix = scene.camera.matrix_world.inverted()
    view.view_perspective = "PERSP"
    space.shading.type = "RENDERED"
    answer["times"] = []


def technique(name: str) -> Any:
    def step(answer: dict[str, Any]) -> None:
        bpy.context.scene.penumbra.technique = name

    return step


def after_a_turn(answer: dict[str, Any]) -> Iterator[None]:
    """The view turns once, then rests until its full picture stands there."""
    view, seen = viewport_of()[2], engine()
    for _ in range(VIEWS):
        asked, pictures, started = seen._asked, seen.pictures, time.perf_counter()
        view.view_rotation = TURN @ view.view_rotation
        while seen._asked == asked:
            yield
        while not seen.rests:
            yield
        _note(answer, "turn", seen, time.perf_counter() - started, seen.pictures - pictures)


def after_a_move(answer: dict[str, Any]) -> Iterator[None]:
    """An object moves: its matrix is read, the caster is drawn anew."""
    seen = engine()
    moving = max((obj for obj in bpy.context.scene.objects if obj.type == "MESH"), key=lambda obj: obj.location.z)
    for _ in range(VIEWS):
        asked, pictures, started = seen._asked, seen.pictures, time.perf_counter()
        moving.location.x += 0.01
        while seen._asked == asked:
            yield
        while not seen.rests:
            yield
        _note(answer, "move", seen, time.perf_counter() - started, seen.pictures - pictures)


def while_orbiting(answer: dict[str, Any]) -> Iterator[None]:
    """The view turns with every turn of the event loop: what a hand on the mouse sees."""
    view, seen = viewport_of()[2], engine()
    pictures, started, views = seen.pictures, time.perf_counter(), 0
    while time.perf_counter() - started < ORBIT_S:
        view.view_rotation = TURN @ view.view_rotation
        views += 1
        yield
    _note(answer, "orbit", seen, (time.perf_counter() - started) / views, (seen.pictures - pictures) / ORBIT_S)


def _note(answer: dict[str, Any], what: str, seen: Any, seconds: float, pictures: float) -> None:
    answer["times"].append(
        {
            "technique": bpy.context.scene.penumbra.technique,
            "what": what,
            "seconds": seconds,
            "pictures": pictures,
            **vars(seen.times),
        }
    )


def workbench(answer: dict[str, Any]) -> None:
    """What the overlay lies on; it takes the same part of the viewport."""
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    viewport_of()[1].shading.type = "SOLID"


def overlay(answer: dict[str, Any]) -> None:
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.first, chosen.second, chosen.left, chosen.right = "shadow_map", "smoothies", "A", "B"
    operate(bpy.ops.penumbra.overlay)


def overlay_with_error(answer: dict[str, Any]) -> None:
    """With the legend and the figures under the cursor."""
    bpy.context.window_manager.penumbra_overlay.right = "ERROR"
    viewport_of()[0].tag_redraw()
    (kept,) = module("viewport.overlay")._state.regions.values()
    kept.cursor = (SIZE[0] // 3, SIZE[1] // 3)


def redraws(name: str) -> Any:
    """Redraws of the resting viewport: all of each, to the screen, and what Blender waits for in the overlay."""

    def step(answer: dict[str, Any]) -> None:
        whole, ours = [], []
        for _ in range(VIEWS):
            started = time.perf_counter()
            operate(bpy.ops.wm.redraw_timer, type="DRAW_WIN_SWAP", iterations=1)
            whole.append(time.perf_counter() - started)
            ours += [kept.times.draw for kept in module("viewport.overlay")._state.regions.values()]
        uploads = [kept.times.upload for kept in module("viewport.overlay")._state.regions.values()]
        answer[name] = {
            "redraw": statistics.median(whole),
            "overlay": statistics.median(ours) if ours else 0.0,
            "upload": max(uploads, default=0.0),
        }

    return step


def finish(answer: dict[str, Any]) -> None:
    (OUT / "times.json").write_text(json.dumps(answer))


measured = [
    step
    for name in ("shadow_map", "smoothies")
    for step in (
        technique(name),
        viewports_ready,
        in_every_turn(after_a_turn),
        in_every_turn(after_a_move),
        in_every_turn(while_orbiting),
        viewports_ready,
    )
]
play(
    install_from(ZIP),
    open_example("courtyard"),
    arrange,
    *measured,
    workbench,
    redraws("without"),
    overlay,
    overlay_ready,
    redraws("with"),
    overlay_with_error,
    overlay_ready,
    redraws("with_error"),
    finish,
)
