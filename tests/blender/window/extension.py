"""Inside Blender's window, without network: the whole extension installed by Blender's command line, used from there
and in the window, switched on and off again and again, reloaded.

Arguments: the extension zip.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from in_window import (
    EXAMPLES,
    NOT_YET,
    OUT,
    PACKAGE,
    Step,
    install_from,
    open_example,
    operate,
    overlay_ready,
    play,
    resident_mb,
    threads_gone,
    viewport_of,
    viewports_ready,
)

ZIP = sys.argv[-1]
SCENE = str(EXAMPLES / "courtyard.blend")
ROUNDS = 5


def command(name: str, *words: str) -> tuple[Step, Step]:
    """Starts another Blender, as a user does; then waits for it while this one goes on drawing."""
    started: list[subprocess.Popen[str]] = []

    def start(answer: dict[str, Any]) -> None:
        started.append(
            subprocess.Popen(["blender", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        )

    def wait(answer: dict[str, Any]) -> object:
        if started[0].poll() is None:
            return NOT_YET
        assert started[0].stdout is not None
        answer[name] = [started[0].returncode, started[0].stdout.read()]
        return None

    return start, wait


def remains() -> dict[str, Any]:
    """All that an add-on can leave in Blender."""
    lists = [getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)]
    handlers = [function for each in lists if isinstance(each, list) for function in each]
    keys = bpy.context.window_manager.keyconfigs.addon.keymaps
    owners = (bpy.types.Scene, bpy.types.ViewLayer, bpy.types.WindowManager, bpy.types.Object, bpy.types.Light)
    engines = [each for each in bpy.types.RenderEngine.__subclasses__() if each.__module__.startswith(PACKAGE)]
    return {
        "engines": [engine.bl_idname for engine in engines if engine.is_registered],
        "types": [name for name in dir(bpy.types) if "penumbra" in name.lower()],
        "properties": [
            f"{owner.__name__}.{name}"
            for owner in owners
            for name in owner.bl_rna.properties.keys()  # noqa: SIM118  # Blender's collections do not iterate keys
            if "penumbra" in name
        ],
        "operators": dir(bpy.ops.penumbra),
        "handlers": [function.__name__ for function in handlers if PACKAGE in function.__module__],
        "keys": [item.idname for keymap in keys for item in keymap.keymap_items if "penumbra" in item.idname],
        "threads": [thread.name for thread in threading.enumerate() if "Penumbra" in thread.name],
        "environment": [name for name in os.environ if name.startswith("PENUMBRA")],
    }


def before(answer: dict[str, Any]) -> None:
    answer["before"] = remains()


def switch_on(answer: dict[str, Any]) -> None:
    bpy.ops.preferences.addon_enable(module=PACKAGE)
    answer.setdefault("on", []).append(remains())


def off_again(answer: dict[str, Any]) -> None:
    """Installing it in this Blender switched it on."""
    bpy.ops.preferences.addon_disable(module=PACKAGE)


def use(answer: dict[str, Any]) -> None:
    """Viewport and F12; the overlay comes next."""
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    scene.penumbra.pixel_samples = 1
    scene.render.resolution_percentage = 20
    scene.render.filepath = str(OUT / "window.png")
    bpy.ops.render.render(write_still=True)
    viewport_of()[1].shading.type = "RENDERED"


def overlay(answer: dict[str, Any]) -> None:
    operate(bpy.ops.penumbra.overlay)


def switch_off(answer: dict[str, Any]) -> None:
    """While the viewport renders and the overlay is on."""
    bpy.ops.preferences.addon_disable(module=PACKAGE)
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    viewport_of()[1].shading.type = "SOLID"


def look(answer: dict[str, Any]) -> None:
    answer.setdefault("off", []).append(remains())
    answer.setdefault("system_threads", []).append(len(os.listdir("/proc/self/task")))
    answer.setdefault("files", []).append(len(os.listdir("/proc/self/fd")))
    answer.setdefault("resident_mb", []).append(resident_mb())


def reload(answer: dict[str, Any]) -> None:
    """*Reload Scripts*: everything is switched off and on by Blender."""
    bpy.ops.script.reload()
    answer["reloaded"] = remains()


each_round = (switch_on, use, viewports_ready, overlay, overlay_ready, switch_off, threads_gone, look)
play(
    before,
    *command("install", "--command", "extension", "install-file", "-r", "user_default", "--enable", ZIP),
    *command("doctor", "--background", "--command", "penumbra", "doctor"),
    *command("render", "--background", SCENE, "--command", "penumbra", "render", "--technique", "smoothies",
             "--size", "160x90", "--out", f"{OUT}/render.png"),
    *command("compare", "--background", SCENE, "--command", "penumbra", "compare", "--techniques", "shadow_map,pcf",
             "--size", "96x54", "--reference-error", "0.05", "--out", f"{OUT}/compare"),
    open_example("courtyard"), install_from(ZIP), off_again, *(each_round * ROUNDS), switch_on, reload, use,
    viewports_ready,
)  # fmt: skip
