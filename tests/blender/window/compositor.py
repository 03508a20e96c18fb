"""Inside Blender's window: the compositor's group of nodes, as an artist finds it after one click.

Arguments: the extension zip.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from in_window import box_of, install_from, open_example, picture, play, region_of, show_tab, window


def editor() -> tuple[Any, Any]:
    area = max(window().screen.areas, key=lambda area: area.width * area.height)
    return area, region_of(area)


def arrange(answer: dict[str, Any]) -> None:
    scene = bpy.context.scene
    scene.render.engine = "PENUMBRA"
    scene.render.resolution_percentage = 20
    scene.penumbra.pixel_samples = 1
    area, _ = editor()
    area.type = "NODE_EDITOR"
    area.ui_type = "CompositorNodeTree"


def add(answer: dict[str, Any]) -> None:
    area, region = editor()
    area.spaces.active.show_region_ui = True
    with bpy.context.temp_override(window=window(), area=area, region=region):
        answer["added"] = sorted(bpy.ops.penumbra.compositor_compare("INVOKE_DEFAULT"))


def fit(answer: dict[str, Any]) -> None:
    area, region = editor()
    show_tab(area)
    with bpy.context.temp_override(window=window(), area=area, region=region):
        bpy.ops.node.view_all()
    left, top, _, height = box_of(region)
    answer["editor"] = [left, top, area.width, height]  # with its sidebar


def inside(answer: dict[str, Any]) -> None:
    area, region = editor()
    tree = area.spaces.active.edit_tree
    node = next(node for node in tree.nodes if node.bl_idname == "CompositorNodeGroup")
    for other in tree.nodes:
        other.select = other == node
    tree.nodes.active = node
    with bpy.context.temp_override(window=window(), area=area, region=region):
        bpy.ops.node.group_edit()


def render(answer: dict[str, Any]) -> None:
    """Stills with the line at the left edge, in the middle and at the right edge."""
    scene = bpy.context.scene
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
    node = next(node for node in scene.node_tree.nodes if node.bl_idname == "CompositorNodeGroup")
    for name, position in (("b", 0.0), ("wipe", 0.5), ("a", 1.0)):
        node.inputs["Position"].default_value = position
        scene.render.filepath = f"/out/{name}.exr"
        bpy.ops.render.render(write_still=True)


play(
    install_from(sys.argv[-1]), open_example("courtyard"), arrange, add, fit, fit, picture("nodes"), inside, fit,
    picture("inside"), render,
)  # fmt: skip
