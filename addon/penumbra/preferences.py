"""What belongs to the machine and not to a file: the device, the view, the cache, the threads; and what works here."""

from __future__ import annotations

import os
import textwrap
from typing import Any

import bpy

from . import doctor
from .properties import with_properties

_PACKAGE = __package__ or "penumbra"
_WRAP = 88


def preferences() -> Any | None:
    """The add-on's preferences; None where it was registered without being an add-on (the pip package)."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon is not None else None


def device() -> str:
    """What the core takes as a device: "" for the first that serves."""
    own = preferences()
    return (str(own.device).strip() if own is not None else "") or os.environ.get("PENUMBRA_DEVICE", "")


def view_by() -> str:
    """What is chosen, see native.view_by(); "" where nothing was, so that PENUMBRA_VIEW_BY decides."""
    own = preferences()
    return str(own.view_by) if own is not None and own.is_property_set("view_by") else ""


def apply() -> None:
    """Hands the cache and the threads on to the core and the command line, which hear the environment."""
    own = preferences()
    if own is None:
        return
    for variable, value in (("PENUMBRA_CACHE", bpy.path.abspath(own.cache)), ("PENUMBRA_THREADS", own.threads)):
        if value:
            os.environ[variable] = str(value)
            _set_by_us.add(variable)
        elif variable in _set_by_us:
            os.environ.pop(variable, None)
            _set_by_us.discard(variable)


_set_by_us: set[str] = set()


@with_properties(
    device=bpy.props.StringProperty(
        name="Device",
        description="Number or part of the name of the graphics device; empty for the first one that serves",
        default="",
    ),
    view_by=bpy.props.EnumProperty(
        name="View",
        description="What finds the surface in each pixel; until something is chosen, PENUMBRA_VIEW_BY decides",
        items=[
            ("raster", "Drawn", "OpenGL draws it"),
            ("rays", "Traced", "Rays look for it, faster without a graphics card, the more so the heavier the meshes"),
        ],
        default="raster",
    ),
    cache=bpy.props.StringProperty(
        name="Cache",
        description="Folder that keeps the ray-traced truth between comparisons; empty for the user's cache folder",
        subtype="DIR_PATH",
        default="",
    ),
    reports=bpy.props.StringProperty(
        name="Reports",
        description="Folder for the reports of comparisons; empty for a folder beside each .blend file",
        subtype="DIR_PATH",
        default="",
    ),
    threads=bpy.props.IntProperty(
        name="Threads",
        description="Processor threads for rays, 0 for all of them. Counts from the next start of Blender on",
        default=0, min=0, max=1024,
    ),
)  # fmt: skip
class PENUMBRA_AP_preferences(bpy.types.AddonPreferences):  # noqa: N801
    bl_idname = _PACKAGE

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "device")
        layout.prop(self, "view_by")
        layout.prop(self, "cache")
        layout.prop(self, "reports")
        layout.prop(self, "threads")
        row = layout.row()
        row.operator(PENUMBRA_OT_examine.bl_idname, icon="VIEWZOOM")
        row.operator(PENUMBRA_OT_copy_examination.bl_idname, icon="COPYDOWN")
        if PENUMBRA_OT_examine.text:
            _draw_text(layout.box(), PENUMBRA_OT_examine.text)


def _draw_text(layout: Any, text: str) -> None:
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in text.splitlines():
        for part in textwrap.wrap(line, _WRAP, subsequent_indent="        ") or [""]:
            column.label(text=part)


class PENUMBRA_OT_examine(bpy.types.Operator):  # noqa: N801
    """Look at what Penumbra needs on this machine: graphics device, OpenGL, rays, libraries"""

    bl_idname = "penumbra.examine"
    bl_label = "What Works Here"
    bl_options = {"REGISTER"}  # noqa: RUF012
    text = ""

    def execute(self, context: Any) -> set[str]:
        checks = doctor.examine(device(), view_by())
        type(self).text = doctor.text(checks)
        if not doctor.healthy(checks):
            self.report({"WARNING"}, "Penumbra cannot work here yet; see its preferences")
        return {"FINISHED"}


class PENUMBRA_OT_copy_examination(bpy.types.Operator):  # noqa: N801
    """Copy what was found to the clipboard, for a report of a problem"""

    bl_idname = "penumbra.copy_examination"
    bl_label = "Copy"
    bl_options = {"REGISTER"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        if not PENUMBRA_OT_examine.text:
            PENUMBRA_OT_examine.text = doctor.text(doctor.examine(device(), view_by()))
        context.window_manager.clipboard = PENUMBRA_OT_examine.text
        self.report({"INFO"}, "Copied to the clipboard")
        return {"FINISHED"}


_CLASSES = (PENUMBRA_OT_examine, PENUMBRA_OT_copy_examination, PENUMBRA_AP_preferences)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    PENUMBRA_OT_examine.text = ""
    while _set_by_us:
        os.environ.pop(_set_by_us.pop(), None)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
