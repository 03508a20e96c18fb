"""Inside Blender's window: the overlay on top of Workbench, its wipe dragged by a simulated mouse, its figures.

Arguments: the extension zip, a .blend file. Blender was started with --enable-event-simulate.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from in_window import (
    PACKAGE,
    box_of,
    install_from,
    module,
    operate,
    overlay_ready,
    play,
    region_of,
    show_tab,
    take_picture,
    threads_gone,
    viewport_of,
    window,
)

ZIP, BLEND = sys.argv[-2:]
ISOLATED = ("Ground", "Plinth", "Suzanne", "Key")
PENUMBRA = (0.356, 0.449)  # a place of the viewport amid the shadow of a flower pot's tree


def open_file(answer: dict[str, Any]) -> None:
    bpy.ops.wm.open_mainfile(filepath=BLEND, load_ui=False)


def prepare(answer: dict[str, Any]) -> None:
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    _, space, view = viewport_of()
    space.show_region_toolbar = space.show_region_header = False
    view.view_perspective = "CAMERA"
    space.shading.type = "SOLID"


def plain(answer: dict[str, Any]) -> None:
    answer["region"] = box_of(region_of(viewport_of()[0]))
    take_picture("plain.png")


def switch(answer: dict[str, Any]) -> None:
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.first, chosen.second = "shadow_map", "light_samples"
    operate(bpy.ops.penumbra.overlay)


def on(answer: dict[str, Any]) -> None:
    take_picture("on.png")


def drag(answer: dict[str, Any]) -> None:
    """From the middle a quarter of the region to the right."""
    region, simulate = region_of(viewport_of()[0]), window().event_simulate
    x, y = region.x + region.width // 2, region.y + region.height // 3
    simulate("MOUSEMOVE", "NOTHING", x=x - 40, y=y)
    simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
    simulate("LEFTMOUSE", "PRESS", x=x, y=y)
    for step in range(1, 9):
        simulate("MOUSEMOVE", "NOTHING", x=x + step * region.width // 32, y=y)
    simulate("LEFTMOUSE", "RELEASE", x=x + region.width // 4, y=y)


def dragged(answer: dict[str, Any]) -> None:
    answer["wipe"] = bpy.context.window_manager.penumbra_overlay.wipe
    take_picture("dragged.png")


def point(answer: dict[str, Any]) -> None:
    region = region_of(viewport_of()[0])
    x, y = region.x + int(PENUMBRA[0] * region.width), region.y + int(PENUMBRA[1] * region.height)
    window().event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)


def error(answer: dict[str, Any]) -> None:
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.left, chosen.right, chosen.wipe = "ERROR", "REFERENCE", 0.45
    viewport_of()[1].show_region_ui = True  # as an artist would have it who chose them


def open_sidebar(answer: dict[str, Any]) -> None:
    """The tab of Penumbra, where the choice is made."""
    show_tab(viewport_of()[0])


def traced(answer: dict[str, Any]) -> None:
    take_picture("error.png")
    (kept,) = module("viewport.overlay")._state.regions.values()
    _, _, width, height = answer["region"]
    answer["cursor"] = kept.cursor
    area = viewport_of()[0]
    answer["free"] = region_of(area, "UI").x - region_of(area).x
    answer["figures"] = kept.worker.shown.at(kept.cursor[0] / width, kept.cursor[1] / height)


def split(answer: dict[str, Any]) -> None:
    """Two viewports side by side, both with the whole scene."""
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.left, chosen.right, chosen.wipe = "A", "B", 0.5
    space = viewport_of()[1]
    space.show_region_ui = space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    operate(bpy.ops.screen.area_split, direction="VERTICAL", factor=0.5)


def viewports() -> list[Any]:
    return [area for area in window().screen.areas if area.type == "VIEW_3D"]


def show_viewports(answer: dict[str, Any], name: str) -> None:
    take_picture(f"{name}.png")
    answer[name] = [box_of(region_of(area)) for area in viewports()]
    scenes = module("viewport.overlay")._state.scenes.values()
    answer[f"{name} objects"] = sorted(sorted(scene.sync.export.instance_names) for scene in scenes)


def both(answer: dict[str, Any]) -> None:
    show_viewports(answer, "both")


def isolate(answer: dict[str, Any]) -> None:
    """The first viewport alone shows a few objects alone."""
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name in ISOLATED)
    operate(bpy.ops.view3d.localview, frame_selected=False)
    bpy.ops.object.select_all(action="DESELECT")


def isolated(answer: dict[str, Any]) -> None:
    show_viewports(answer, "isolated")


def move_in_local_view(answer: dict[str, Any]) -> None:
    bpy.data.objects["Suzanne"].location.x += 1.5


def moved(answer: dict[str, Any]) -> None:
    show_viewports(answer, "moved")


def leave(answer: dict[str, Any]) -> None:
    bpy.data.objects["Suzanne"].location.x -= 1.5
    operate(bpy.ops.view3d.localview, frame_selected=False)


def hide_a_type(answer: dict[str, Any]) -> None:
    show_viewports(answer, "left")
    viewport_of()[1].show_object_viewport_mesh = False


def hidden(answer: dict[str, Any]) -> None:
    show_viewports(answer, "hidden")
    viewport_of()[1].show_object_viewport_mesh = True


def join(answer: dict[str, Any]) -> None:
    """The second viewport goes, and what the overlay keeps of it with the next change."""
    operate_in = viewports()[1]
    with bpy.context.temp_override(window=window(), area=operate_in, region=region_of(operate_in)):
        bpy.ops.screen.area_close()
    bpy.data.objects["Suzanne"].update_tag()


def joined(answer: dict[str, Any]) -> None:
    answer["regions after closing"] = len(module("viewport.overlay")._state.regions)


def off(answer: dict[str, Any]) -> None:
    operate(bpy.ops.penumbra.overlay)


def gone(answer: dict[str, Any]) -> None:
    take_picture("off.png")
    answer["handlers"] = [
        f.__module__ for hs in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.load_pre) for f in hs
        if "penumbra" in f.__module__
    ]  # fmt: skip


def load_while_on(answer: dict[str, Any]) -> None:
    switch(answer)
    bpy.ops.wm.open_mainfile(filepath=BLEND, load_ui=False)


def after_load(answer: dict[str, Any]) -> None:
    answer["on_after_load"] = module("viewport.overlay").is_on()
    switch(answer)


def disable_while_on(answer: dict[str, Any]) -> None:
    bpy.ops.preferences.addon_disable(module=PACKAGE)
    answer["left_behind"] = [name for name in dir(bpy.types) if "PENUMBRA" in name]


ready = overlay_ready
play(
    install_from(ZIP), open_file, prepare, plain, switch, ready, on, drag, dragged, point, error, open_sidebar, ready,
    traced, split, ready, both, isolate, ready, isolated, move_in_local_view, ready, moved, leave, ready, hide_a_type,
    ready, hidden, ready, join, ready, joined, off, threads_gone, gone, load_while_on, after_load, disable_while_on,
    threads_gone,
)  # fmt: skip
