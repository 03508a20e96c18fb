"""Inside Blender's window: the extension is installed from its zip, and Penumbra draws the 3D viewport.

Arguments: the extension zip, a .blend file.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import bpy
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))
from in_window import (
    PACKAGE,
    Step,
    box_of,
    install_from,
    module,
    play,
    region_of,
    resident_mb,
    take_picture,
    threads_gone,
    viewport_of,
    viewports_ready,
)

ZIP, BLEND = sys.argv[-2:]


def furnish(answer: dict[str, Any]) -> None:
    """A floor from above, its right half behind a blocker that the view does not see."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)

    def add(name: str, data: Any, z: float) -> Any:
        item = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(item)
        item.location = (0, 0, z)
        return item

    for name, x0, z in (("Floor", -20.0, 0.0), ("Blocker", 0.0, 1.0)):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(x0, -20, 0), (20, -20, 0), (20, 20, 0), (x0, 20, 0)], [], [(0, 1, 2, 3)])
        add(name, mesh, z).visible_camera = name == "Floor"
    light = bpy.data.lights.new("Key", "POINT")
    light.energy, light.shadow_soft_size = 400, 0.0
    add("Key", light, 3)
    scene = bpy.context.scene
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.view_settings.view_transform = "Standard"
    scene.render.engine = "PENUMBRA"
    scene.penumbra.pixel_samples = 1
    _, space, view = viewport_of()
    space.overlay.show_overlays = False
    space.show_gizmo = space.show_region_ui = space.show_region_toolbar = space.show_region_header = False
    view.view_perspective = "ORTHO"
    view.view_rotation = (1, 0, 0, 0)
    view.view_location, view.view_distance = (0, 0, 0), 3
    space.shading.type = "RENDERED"


def where(answer: dict[str, Any], name: str) -> None:
    """Picture of the screen, and the pixels of the viewport's quarters in it (from the top left)."""
    left, top, width, height = answer["region"] = box_of(region_of(viewport_of()[0]))
    middle = top + height // 2
    answer[name] = {"left": [left + width // 4, middle], "right": [left + 3 * width // 4, middle]}
    take_picture(f"{name}.png")


def top(answer: dict[str, Any]) -> None:
    where(answer, "top")


def turn_round(answer: dict[str, Any]) -> None:
    viewport_of()[2].view_rotation = Euler((0, 0, math.pi)).to_quaternion()


def turned(answer: dict[str, Any]) -> None:
    where(answer, "turned")


def soften(answer: dict[str, Any]) -> None:
    viewport_of()[2].view_rotation = (1, 0, 0, 0)
    bpy.data.lights["Key"].shadow_soft_size = 0.5
    bpy.context.scene.penumbra.technique = "light_samples"


def soft(answer: dict[str, Any]) -> None:
    where(answer, "soft")


def move(answer: dict[str, Any]) -> None:
    bpy.data.objects["Blocker"].location.x = 9


def moved(answer: dict[str, Any]) -> None:
    where(answer, "moved")


def dazzle(answer: dict[str, Any]) -> None:
    """Far more light than a half float holds."""
    bpy.data.objects["Blocker"].location.x = 0
    bpy.data.lights["Key"].energy = 1e9


def dazzled(answer: dict[str, Any]) -> None:
    where(answer, "dazzled")


def break_it(answer: dict[str, Any]) -> None:
    bpy.data.lights["Key"].energy = 400
    bpy.context.preferences.addons[PACKAGE].preferences.device = "nobody's device"
    bpy.context.scene.penumbra.technique = "shadow_map"


def broken(answer: dict[str, Any]) -> None:
    where(answer, "broken")


def mend(answer: dict[str, Any]) -> None:
    bpy.context.preferences.addons[PACKAGE].preferences.device = ""
    bpy.context.scene.penumbra.technique = "pcf"


def mended(answer: dict[str, Any]) -> None:
    where(answer, "mended")


def twenty_views(number: int) -> Step:
    def views(answer: dict[str, Any]) -> None:
        (engine,) = module("viewport.engine_view").EngineView.alive
        before = engine.pictures
        for step in range(20 * number, 20 * number + 20):
            viewport_of()[2].view_rotation = Euler((0.6 * math.sin(step / 9), 0, step / 20)).to_quaternion()
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        answer["pictures"] = answer.get("pictures", 0) + engine.pictures - before

    return views


def measure(answer: dict[str, Any]) -> None:
    """At rest: a picture in the making takes what it takes."""
    answer.setdefault("resident_mb", []).append(resident_mb())


def open_file(answer: dict[str, Any]) -> None:
    bpy.ops.wm.open_mainfile(filepath=BLEND, load_ui=False)


def in_camera(answer: dict[str, Any]) -> None:
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    scene.penumbra.technique = "smoothies"
    _, space, view = viewport_of()
    space.shading.type = "RENDERED"
    view.view_perspective = "CAMERA"


def seen_by_camera(answer: dict[str, Any]) -> None:
    where(answer, "camera")


def solid_again(answer: dict[str, Any]) -> None:
    viewport_of()[1].shading.type = "SOLID"
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"


def switch_off(answer: dict[str, Any]) -> None:
    where(answer, "solid")
    bpy.ops.preferences.addon_disable(module=PACKAGE)
    answer["left_behind"] = [name for name in dir(bpy.types) if "PENUMBRA" in name]


ready = viewports_ready
play(
    install_from(ZIP), furnish, ready, top, turn_round, ready, turned, soften, ready, soft, move, ready, moved,
    dazzle, ready, dazzled, break_it, ready, broken, mend, ready, mended,
    *(step for number in range(10) for step in (twenty_views(number), ready, measure)),
    open_file, in_camera, ready, seen_by_camera, solid_again, threads_gone, switch_off,
)  # fmt: skip
