"""Runs inside Blender's window (tools/blender_window run): steps between which Blender draws, a picture of the screen,
and an answer in JSON for the test outside.
"""

from __future__ import annotations

import json
import subprocess
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

OUT = Path("/out")

Step = Callable[[dict[str, Any]], object]
NOT_YET = "not yet"
_LONGEST_WAIT_S = 60.0


def play(*steps: Step, pause_s: float = 1.0) -> None:
    """Runs the steps from Blender's event loop, with time to draw before each; then ends Blender.

    Every step adds to one dictionary, which becomes /out/answer.json. A step that answers NOT_YET is played again, a
    minute at most. An exception ends the play, as `error` in there.
    """
    bpy.context.preferences.view.show_splash = False
    answer: dict[str, Any] = {"blender": bpy.app.version_string, "background": bpy.app.background}
    waiting = list(steps)
    since = time.monotonic()

    def next_step() -> float | None:
        nonlocal since
        try:
            if waiting:
                if waiting[0](answer) == NOT_YET:
                    if time.monotonic() - since > _LONGEST_WAIT_S:
                        raise TimeoutError(f"step {len(steps) - len(waiting)} waited in vain")
                else:
                    waiting.pop(0)
                    since = time.monotonic()
                return pause_s
        except Exception:
            answer["error"] = traceback.format_exc()
        (OUT / "answer.json").write_text(json.dumps(answer))
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(next_step, first_interval=pause_s, persistent=True)  # a step may open a file


def take_picture(name: str) -> None:
    """What the X server shows. Blender's own screenshot operator gives a black one here."""
    subprocess.run(["import", "-window", "root", str(OUT / name)], check=True, timeout=60)


def viewport_of() -> tuple[Any, Any, Any]:
    """Area, space and view of the first 3D viewport."""
    for area in bpy.context.window_manager.windows[0].screen.areas:
        if area.type == "VIEW_3D":
            return area, area.spaces.active, area.spaces.active.region_3d
    raise LookupError("no 3D viewport")
