"""Inside Blender's window: the extension's preferences, what works here, and its copy.

Arguments: the extension zip.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from in_window import PACKAGE, box_of, install_from, picture, play, region_of, viewport_of


def show(answer: dict[str, Any]) -> None:
    """Unfolded, as a click on its arrow does, in place of the viewport."""
    import addon_utils

    addon_utils.modules(refresh=True)
    addon_utils.module_bl_info(addon_utils.addons_fake_modules[PACKAGE])["show_expanded"] = True
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Penumbra"
    area = viewport_of()[0]
    area.type = "PREFERENCES"
    answer["area"] = box_of(region_of(area))


def examine(answer: dict[str, Any]) -> None:
    answer["examined"] = sorted(bpy.ops.penumbra.examine())
    answer["copied"] = sorted(bpy.ops.penumbra.copy_examination())
    answer["clipboard"] = bpy.context.window_manager.clipboard
    for area in bpy.context.window_manager.windows[0].screen.areas:
        area.tag_redraw()


play(install_from(sys.argv[-1]), show, picture("before"), examine, picture("preferences"))
