"""Inside Blender's window: the extension is installed from its zip, and Penumbra draws the 3D viewport.

Arguments: the extension zip, a .blend file.
"""

from __future__ import annotations

import math
import resource
import sys
import time
from pathlib import Path
from typing import Any

import bpy
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))
from in_window import NOT_YET, play, take_picture, viewport_of

ZIP, BLEND = sys.argv[-2:]


def install(answer: dict[str, Any]) -> None:
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    answer["enabled"] = "bl_ext.user_default.penumbra" in bpy.context.preferences.addons
    answer["core_loaded_by_enabling"] = "penumbra_core" in sys.modules


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


def region_px() -> Any:
    area, _, _ = viewport_of()
    return next(region for region in area.regions if region.type == "WINDOW")


def where(answer: dict[str, Any], name: str) -> None:
    """Picture of the screen, and the pixels of the viewport's quarters in it (from the top left)."""
    region = region_px()
    height = bpy.context.window_manager.windows[0].height
    middle = height - (region.y + region.height // 2)
    answer[name] = {
        "left": [region.x + region.width // 4, middle],
        "right": [region.x + 3 * region.width // 4, middle],
    }
    take_picture(f"{name}.png")


def ready(answer: dict[str, Any]) -> object:
    """All that was asked is answered; the next step comes after it is drawn."""
    from bl_ext.user_default.penumbra.viewport.engine_view import EngineView

    views = list(EngineView.alive)
    return None if views and not any(view.busy for view in views) else NOT_YET


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
    bpy.context.preferences.addons["bl_ext.user_default.penumbra"].preferences.device = "nobody's device"
    bpy.context.scene.penumbra.technique = "shadow_map"


def broken(answer: dict[str, Any]) -> None:
    where(answer, "broken")


def mend(answer: dict[str, Any]) -> None:
    bpy.context.preferences.addons["bl_ext.user_default.penumbra"].preferences.device = ""
    bpy.context.scene.penumbra.technique = "pcf"


def mended(answer: dict[str, Any]) -> None:
    where(answer, "mended")


def two_hundred_views(answer: dict[str, Any]) -> None:
    from bl_ext.user_default.penumbra.viewport.engine_view import EngineView

    def resident_mb() -> float:
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20

    sizes, pictures = [], 0
    (engine,) = EngineView.alive
    started = time.perf_counter()
    for step in range(200):
        viewport_of()[2].view_rotation = Euler((0.6 * math.sin(step / 9), 0, step / 20)).to_quaternion()
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        if step % 20 == 0:
            sizes.append(resident_mb())
    pictures = engine.pictures
    answer["memory_mb"] = sizes
    answer["views_s"] = time.perf_counter() - started
    answer["pictures"] = pictures


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
    import threading

    where(answer, "solid")
    answer["threads_in_solid"] = [t.name for t in threading.enumerate() if "Penumbra" in t.name]
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.penumbra")
    answer["left_behind"] = [name for name in dir(bpy.types) if "PENUMBRA" in name]


play(
    install, furnish, ready, top, turn_round, ready, turned, soften, ready, soft, move, ready, moved,
    dazzle, ready, dazzled, break_it, ready, broken, mend, ready, mended, two_hundred_views, open_file, in_camera,
    ready, seen_by_camera, solid_again, switch_off,
    pause_s=1.0,
)  # fmt: skip
