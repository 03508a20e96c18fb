"""Runs inside Blender's window (tools/blender_window run): steps between which Blender draws, a picture of the screen,
and an answer in JSON for the test outside.
"""

from __future__ import annotations

import ctypes
import gc
import importlib
import json
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy

OUT = Path("/out")
EXAMPLES = Path("/penumbra/examples")
PACKAGE = "bl_ext.user_default.penumbra"

Step = Callable[[dict[str, Any]], object]
NOT_YET = "not yet"
_LONGEST_WAIT_S = 240.0  # a machine that builds meanwhile is ten times as slow
_TURNS = 4  # of Blender's event loop between two steps: each draws what is to be drawn


def play(*steps: Step, pause_s: float = 0.6) -> None:
    """Runs the steps from Blender's event loop, with turns of it and time for its animations before each; then ends
    Blender.

    Every step adds to one dictionary, which becomes /out/answer.json. A step that answers NOT_YET is played again, for
    four minutes at most. An exception ends the play, as `error` in there.
    """
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.smooth_view = 0
    bpy.context.preferences.system.viewport_aa = "OFF"  # Blender's own drawing, in software, is the slow part
    answer: dict[str, Any] = {"blender": bpy.app.version_string, "background": bpy.app.background}
    waiting = list(steps)
    since = time.monotonic()
    turns = 0

    def turn() -> float | None:
        nonlocal since, turns
        turns += 1
        if turns < _TURNS:
            return pause_s / _TURNS
        turns = 0
        try:
            if waiting:
                if waiting[0](answer) == NOT_YET:
                    if time.monotonic() - since > _LONGEST_WAIT_S:
                        raise TimeoutError(f"{waiting[0].__name__}, step {len(steps) - len(waiting)}, waited in vain")
                else:
                    _note(waiting.pop(0), answer)
                    since = time.monotonic()
                return pause_s / _TURNS
        except Exception:
            answer["error"] = traceback.format_exc()
            take_picture("error.png")
        (OUT / "answer.json").write_text(json.dumps(answer))
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(turn, first_interval=pause_s, persistent=True)  # a step may open a file


def _note(step: Step, answer: dict[str, Any]) -> None:
    """How far it came, for whoever waits, or where it does not come to its end."""
    with (OUT / "steps.txt").open("a") as file:
        memory = answer.get("resident_mb", [""])[-1]
        file.write(f"{time.strftime('%X')} {getattr(step, '__name__', '')} {memory}\n")


def in_every_turn(script: Callable[[dict[str, Any]], Iterator[None]]) -> Step:
    """A step that goes on, to its next `yield`, in every turn of Blender's event loop, as a hand on the mouse does."""
    state: list[object] = []

    def step(answer: dict[str, Any]) -> object:
        if not state:
            going = script(answer)
            state.append(NOT_YET)

            def go_on() -> float | None:
                try:
                    next(going)
                    return 0.0
                except Exception as error:  # StopIteration is the good end
                    state[0] = error
                    return None

            bpy.app.timers.register(go_on)
        if isinstance(state[0], Exception) and not isinstance(state[0], StopIteration):
            raise state[0]
        return NOT_YET if state[0] == NOT_YET else None

    return step


def take_picture(name: str) -> None:
    """What the X server shows. Blender's own screenshot operator gives a black one here."""
    subprocess.run(["import", "-window", "root", str(OUT / name)], check=True, timeout=60)


def picture(name: str) -> Step:
    """A step that takes one."""

    def step(answer: dict[str, Any]) -> None:
        take_picture(f"{name}.png")

    return step


# ------------------------------------------------------------------------------------------------- places on the screen


def window() -> Any:
    return bpy.context.window_manager.windows[0]


def viewport_of() -> tuple[Any, Any, Any]:
    """Area, space and view of the first 3D viewport."""
    for area in window().screen.areas:
        if area.type == "VIEW_3D":
            return area, area.spaces.active, area.spaces.active.region_3d
    raise LookupError("no 3D viewport")


def region_of(area: Any, kind: str = "WINDOW") -> Any:
    return next(region for region in area.regions if region.type == kind)


def box_of(region: Any, window_: Any = None) -> list[int]:
    """Left, top, width, height in pixels of the screen's picture."""
    height = (window_ or window()).height
    return [region.x, height - region.y - region.height, region.width, region.height]


def operate(call: Any, *given: Any, **named: Any) -> Any:
    """As a click in the viewport does."""
    area = viewport_of()[0]
    with bpy.context.temp_override(window=window(), area=area, region=region_of(area)):
        return call(*given, **named)


def show_tab(area: Any) -> Any:
    """The sidebar's tab of Penumbra; the sidebar has to be open and drawn."""
    sidebar = region_of(area, "UI")
    sidebar.active_panel_category = "Penumbra"
    sidebar.tag_redraw()
    return sidebar


# ----------------------------------------------------------------------------------------------------- the extension


def install_from(zip_path: str) -> Step:
    def install(answer: dict[str, Any]) -> None:
        bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
        answer["enabled"] = PACKAGE in bpy.context.preferences.addons
        answer["core_loaded_by_enabling"] = "penumbra_core" in sys.modules

    return install


def module(name: str) -> Any:
    """Of the installed extension."""
    return importlib.import_module(f"{PACKAGE}.{name}")


def open_example(name: str) -> Step:
    def step(answer: dict[str, Any]) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(EXAMPLES / f"{name}.blend"), load_ui=False)

    return step


def choose(*techniques: str) -> None:
    """For the comparison: these alone."""
    chosen = bpy.context.scene.penumbra_comparison.techniques
    for info in module("catalogue").techniques():
        setattr(chosen, info["id"], info["id"] in techniques)


def viewports_ready(answer: dict[str, Any]) -> object:
    """All that the viewports asked for is answered and drawn."""
    views = list(module("viewport.engine_view").EngineView.alive)
    return None if views and all(view.rests for view in views) else NOT_YET


def overlay_ready(answer: dict[str, Any]) -> object:
    """All that the overlay asked for is answered and drawn."""
    return None if module("viewport.overlay").rests() else NOT_YET


def comparison_over(answer: dict[str, Any]) -> object:
    return NOT_YET if module("comparison.running").current() is not None else None


def threads_gone(answer: dict[str, Any]) -> object:
    """Closing waits two seconds for a thread, which on a busy machine may take longer to hear of it."""
    return NOT_YET if any("Penumbra" in thread.name for thread in threading.enumerate()) else None


def resident_mb() -> float:
    """Memory in use: what the allocator only keeps for later is given back before."""
    gc.collect()
    everybody = ctypes.CDLL(None)
    if hasattr(everybody, "mallctl"):  # jemalloc, of Debian's Blender; 4096 stands for all arenas
        everybody.mallctl(b"arena.4096.purge", None, None, None, ctypes.c_size_t(0))
    else:
        everybody.malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20
