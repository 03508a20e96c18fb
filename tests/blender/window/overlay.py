"""Inside Blender's window: the overlay on top of Workbench, its wipe dragged by a simulated mouse, its figures.

Arguments: the extension zip, a .blend file. Blender was started with --enable-event-simulate.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from in_window import NOT_YET, play, take_picture, viewport_of

ZIP, BLEND = sys.argv[-2:]


def install(answer: dict[str, Any]) -> None:
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    bpy.ops.wm.open_mainfile(filepath=BLEND, load_ui=False)


def prepare(answer: dict[str, Any]) -> None:
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    area, space, view = viewport_of()
    space.show_region_toolbar = space.show_region_header = False
    view.view_perspective = "CAMERA"
    space.shading.type = "SOLID"
    region = next(region for region in area.regions if region.type == "WINDOW")
    height = bpy.context.window_manager.windows[0].height
    answer["region"] = [region.x, height - region.y - region.height, region.width, region.height]


def plain(answer: dict[str, Any]) -> None:
    take_picture("plain.png")


def switch(answer: dict[str, Any]) -> None:
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.first, chosen.second = "shadow_map", "light_samples"
    area = viewport_of()[0]
    with bpy.context.temp_override(area=area, region=next(r for r in area.regions if r.type == "WINDOW")):
        bpy.ops.penumbra.overlay()


def ready(answer: dict[str, Any]) -> object:
    """All that was asked is answered; the next step comes after it is drawn."""
    from bl_ext.user_default.penumbra.viewport import overlay

    workers = [kept.worker for kept in overlay._state.regions.values()]
    return None if workers and not any(worker.busy for worker in workers) else NOT_YET


def on(answer: dict[str, Any]) -> None:
    take_picture("on.png")


def drag(answer: dict[str, Any]) -> None:
    """From the middle a quarter of the region to the right."""
    window = bpy.context.window_manager.windows[0]
    area = viewport_of()[0]
    region = next(region for region in area.regions if region.type == "WINDOW")
    x, y = region.x + region.width // 2, region.y + region.height // 3
    window.event_simulate("MOUSEMOVE", "NOTHING", x=x - 40, y=y)
    window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
    window.event_simulate("LEFTMOUSE", "PRESS", x=x, y=y)
    for step in range(1, 9):
        window.event_simulate("MOUSEMOVE", "NOTHING", x=x + step * region.width // 32, y=y)
    window.event_simulate("LEFTMOUSE", "RELEASE", x=x + region.width // 4, y=y)


def dragged(answer: dict[str, Any]) -> None:
    answer["wipe"] = bpy.context.window_manager.penumbra_overlay.wipe
    take_picture("dragged.png")


def point(answer: dict[str, Any]) -> None:
    window = bpy.context.window_manager.windows[0]
    region = next(region for region in viewport_of()[0].regions if region.type == "WINDOW")
    x, y = region.x + region.width // 3, region.y + region.height // 3
    window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
    answer["pointed"] = [x, bpy.context.window_manager.windows[0].height - y]


def error(answer: dict[str, Any]) -> None:
    chosen = bpy.context.window_manager.penumbra_overlay
    chosen.left, chosen.right = "ERROR", "REFERENCE"
    viewport_of()[1].show_region_ui = True  # as an artist would have it who chose them


def open_sidebar(answer: dict[str, Any]) -> None:
    """The tab of Penumbra, where the choice is made."""
    area = viewport_of()[0]
    sidebar = next(region for region in area.regions if region.type == "UI")
    sidebar.active_panel_category = "Penumbra"
    area.tag_redraw()


def traced(answer: dict[str, Any]) -> None:
    take_picture("error.png")
    from bl_ext.user_default.penumbra.viewport import overlay

    (kept,) = overlay._state.regions.values()
    answer["figures"] = kept.worker.shown.at(0.4, 0.3)
    answer["cursor"] = kept.cursor


def off(answer: dict[str, Any]) -> None:
    area = viewport_of()[0]
    with bpy.context.temp_override(area=area, region=next(r for r in area.regions if r.type == "WINDOW")):
        bpy.ops.penumbra.overlay()


def gone(answer: dict[str, Any]) -> None:
    import threading

    take_picture("off.png")
    answer["threads"] = [t.name for t in threading.enumerate() if "Penumbra" in t.name]
    answer["handlers"] = [
        f.__module__ for hs in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.load_pre) for f in hs
        if "penumbra" in f.__module__
    ]  # fmt: skip


def load_while_on(answer: dict[str, Any]) -> None:
    switch(answer)
    bpy.ops.wm.open_mainfile(filepath=BLEND, load_ui=False)


def after_load(answer: dict[str, Any]) -> None:
    from bl_ext.user_default.penumbra.viewport import overlay

    answer["on_after_load"] = overlay.is_on()
    switch(answer)


def disable_while_on(answer: dict[str, Any]) -> None:
    import threading

    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.penumbra")
    answer["threads_after_disable"] = [t.name for t in threading.enumerate() if "Penumbra" in t.name]
    answer["left_behind"] = [name for name in dir(bpy.types) if "PENUMBRA" in name]


play(
    install, prepare, plain, switch, ready, on, drag, dragged, point, error, open_sidebar, ready, traced, off, gone,
    load_while_on, after_load, disable_while_on,
    pause_s=1.5,
)  # fmt: skip
