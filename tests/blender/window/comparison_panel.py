"""Inside Blender's window: the comparison panel, from its button to a result in an image editor.

Arguments: the extension zip.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from in_window import (
    NOT_YET,
    OUT,
    box_of,
    choose,
    comparison_over,
    install_from,
    module,
    open_example,
    operate,
    picture,
    play,
    region_of,
    show_tab,
    take_picture,
    viewport_of,
    window,
)

TECHNIQUES = ("shadow_map", "pcf", "smoothies", "plateaus", "light_samples", "ray_traced", "masked_rays")


BROWSER = Path("/tmp/browser")  # a real program, as a user's browser is one


def have_browser(answer: dict[str, Any]) -> None:
    BROWSER.write_text(f"#!/bin/sh\nprintf '%s\\n' \"$@\" >{OUT}/opened.txt\n")
    BROWSER.chmod(0o755)
    os.environ["BROWSER"] = str(BROWSER)
    answer["techniques_there"] = len(module("catalogue").techniques())


def arrange(answer: dict[str, Any]) -> None:
    """The sidebar with our tab in a tall viewport."""
    scene = bpy.context.scene
    kept = scene.penumbra_comparison
    choose(*TECHNIQUES)
    kept.scale, kept.timing_seconds, scene.penumbra.reference_error = 20, 0.2, 0.01
    _, space, _ = viewport_of()
    space.show_region_ui = True
    space.shading.type = "SOLID"


def choose_tab(answer: dict[str, Any]) -> None:
    show_tab(viewport_of()[0])


def unfold(answer: dict[str, Any]) -> None:
    """All panels open, as after a click on each header."""
    panels = module("panel.comparison")
    panels.unregister()
    for panel in panels._CLASSES[1:]:
        panel.bl_options = set()
    panels.register()


def before(answer: dict[str, Any]) -> None:
    answer["sidebar_before"] = box_of(region_of(viewport_of()[0], "UI"))
    take_picture("before.png")
    started = time.monotonic()
    answer["started"] = sorted(operate(bpy.ops.penumbra.compare, "INVOKE_DEFAULT"))
    answer["start_s"] = time.monotonic() - started


def running(answer: dict[str, Any]) -> None:
    current = module("comparison.running").current()
    answer["progress"] = list(current.progress) if current is not None else None
    take_picture("running.png")
    # The artist goes on working.
    obj = bpy.data.objects.new("Meanwhile", None)
    bpy.context.scene.collection.objects.link(obj)
    bpy.ops.ed.undo_push(message="Meanwhile")


def midway(answer: dict[str, Any]) -> object:
    current = module("comparison.running").current()
    return NOT_YET if current is not None and current.progress[0] < 0.4 else None


def results(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    answer["problem"] = module("comparison.running").problem()
    answer["rows"] = [[row.technique, row.status, row.error, row.time_ms] for row in kept.rows]
    take_picture("results.png")


def use_cheapest(answer: dict[str, Any]) -> None:
    """Within the middle one of the errors."""
    scene = bpy.context.scene
    kept = scene.penumbra_comparison
    kept.target = sorted(row.error for row in kept.rows)[len(kept.rows) // 2] + 1e-4
    answer["target"] = kept.target
    answer["used"] = sorted(operate(bpy.ops.penumbra.use_cheapest))
    answer["technique_used"] = scene.penumbra.technique


def open_report(answer: dict[str, Any]) -> None:
    module("preferences").preferences().reports = str(OUT)
    answer["report"] = sorted(operate(bpy.ops.penumbra.open_report))


def report_opened(answer: dict[str, Any]) -> object:
    """The browser is a process of its own."""
    return None if (OUT / "opened.txt").is_file() else NOT_YET


def artist_works(answer: dict[str, Any]) -> None:
    """After the results are there: what is undone next is this, and not they."""
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Later", None))
    bpy.ops.ed.undo_push(message="Later")


def after_undo(answer: dict[str, Any]) -> None:
    operate(bpy.ops.ed.undo)
    answer["rows_after_undo"] = len(bpy.context.scene.penumbra_comparison.rows)
    answer["meanwhile_after_undo"] = "Later" in bpy.data.objects


def editor(answer: dict[str, Any]) -> None:
    with bpy.context.temp_override(window=window(), area=viewport_of()[0]):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.45)
    other = min((a for a in window().screen.areas if a.type == "VIEW_3D"), key=lambda a: a.x)
    other.type = "IMAGE_EDITOR"


def show(answer: dict[str, Any]) -> None:
    rows = [row.technique for row in bpy.context.scene.penumbra_comparison.rows]
    answer["shown"] = sorted(operate(bpy.ops.penumbra.show_result, row=rows.index("plateaus"), what="ERROR"))
    area = next(area for area in window().screen.areas if area.type == "IMAGE_EDITOR")
    answer["shown_image"] = area.spaces.active.image.name
    with bpy.context.temp_override(window=window(), area=area, region=region_of(area)):
        bpy.ops.image.view_all(fit_view=True)
    answer["image_editor"] = box_of(region_of(area))
    answer["sidebar"] = box_of(region_of(viewport_of()[0], "UI"))


def scroll(answer: dict[str, Any]) -> None:
    area = viewport_of()[0]
    sidebar = region_of(area, "UI")
    with bpy.context.temp_override(window=window(), area=area, region=sidebar):
        for _ in range(7):
            bpy.ops.view2d.scroll_down(deltay=80)
    sidebar.tag_redraw()


def make_properties(answer: dict[str, Any]) -> None:
    bpy.context.scene.render.engine = "PENUMBRA"
    next(area for area in window().screen.areas if area.type == "IMAGE_EDITOR").type = "PROPERTIES"


def properties(answer: dict[str, Any]) -> None:
    area = max((a for a in window().screen.areas if a.type == "PROPERTIES"), key=lambda area: area.width)
    area.spaces.active.context = "RENDER"


def click(answer: dict[str, Any]) -> None:
    """On the row of smoothies, which the dot in its colour gives away on the screen."""
    kept = bpy.context.scene.penumbra_comparison
    answer["active_before"] = kept.active_row
    row = next(row for row in kept.rows if row.technique == "smoothies")
    code = module("report.palette").colour(row.colour).lstrip("#")
    sidebar = region_of(viewport_of()[0], "UI")
    screen = bpy.data.images.load("/out/scrolled_1.png")
    pixels = np.empty(screen.size[0] * screen.size[1] * 4, np.float32)
    screen.pixels.foreach_get(pixels)
    left = pixels.reshape(screen.size[1], screen.size[0], 4)[:, sidebar.x + 5 : sidebar.x + 50, :3]
    bpy.data.images.remove(screen)
    found = np.abs(left - np.array(list(bytes.fromhex(code))) / 255).max(axis=-1) < 0.05
    x, y = sidebar.x + 70, round(float(np.nonzero(found)[0].mean()))
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=x, y=y)


def clicked(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    area = next(area for area in window().screen.areas if area.type == "IMAGE_EDITOR")
    answer["clicked"] = kept.rows[kept.active_row].name
    answer["followed"] = area.spaces.active.image["technique"]
    take_picture("clicked.png")


def compare_this_view(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    kept.view, kept.scale = "VIEW", 15
    answer["view_started"] = sorted(operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT"))


def view_results(answer: dict[str, Any]) -> None:
    kept = bpy.context.scene.penumbra_comparison
    answer["view_heading"], answer["view_rows"] = kept.heading, [row.status for row in kept.rows]
    region = region_of(viewport_of()[0])
    answer["view_size"] = [round(region.width * 0.15), round(region.height * 0.15)]


def show_alone(answer: dict[str, Any]) -> None:
    """No image editor is open: the picture gets a window of its own."""
    operate(bpy.ops.penumbra.show_result, row=0, what="SHADED")
    areas = [[area.type for area in each.screen.areas] for each in bpy.context.window_manager.windows]
    answer["windows"] = areas


def leave_while_comparing(answer: dict[str, Any]) -> None:
    bpy.context.scene.penumbra.settings.ray_traced.rays = 65536
    bpy.context.scene.penumbra_comparison.scale = 100
    operate(bpy.ops.penumbra.compare, "EXEC_DEFAULT")
    answer["left_running"] = module("comparison.running").current() is not None


SCROLLED = [step for number in range(1, 9) for step in (scroll, picture(f"scrolled_{number}"))]

if __name__ == "__main__":
    play(
        install_from(sys.argv[-1]), have_browser, unfold, open_example("courtyard"), arrange, choose_tab, before,
        running, midway, picture("midway"), comparison_over, results, use_cheapest, picture("cheapest"), open_report,
        report_opened, artist_works, after_undo, editor, choose_tab, show, picture("shown"), *SCROLLED[:2], click,
        clicked, *SCROLLED[2:], make_properties, properties, picture("properties"), compare_this_view, comparison_over,
        view_results, show_alone, leave_while_comparing,
    )  # fmt: skip
