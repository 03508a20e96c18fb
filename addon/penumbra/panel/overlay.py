"""The overlay's panel in the sidebar of the 3D viewport."""

from __future__ import annotations

from typing import Any

import bpy

from ..viewport import overlay
from ..viewport.overlay_pictures import ERROR, ERROR_OTHER, REFERENCE
from .settings import draw_settings


class PENUMBRA_PT_overlay(bpy.types.Panel):  # noqa: N801
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Penumbra"
    bl_label = "Overlay"
    bl_order = 10

    def draw(self, context: Any) -> None:
        overlay.notice(context)
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        chosen = context.window_manager.penumbra_overlay
        on = overlay.is_on()
        layout.operator("penumbra.overlay", text="Switch Off" if on else "Switch On", icon="MOD_MASK", depress=on)
        column = layout.column()
        column.prop(chosen, "first")
        column.prop(chosen, "second")
        column = layout.column(align=True)
        column.prop(chosen, "left")
        column.prop(chosen, "right")
        column.prop(chosen, "wipe", slider=True)
        column = layout.column()
        column.prop(chosen, "shaded")
        column.prop_search(chosen, "light", context.scene, "objects", icon="LIGHT")
        if {chosen.left, chosen.right} & {ERROR, ERROR_OTHER, REFERENCE}:
            column.prop(chosen, "error_scale")
            column.prop(chosen, "reference_error")


class _Settings(bpy.types.Panel):
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Penumbra"
    bl_parent_id = "PENUMBRA_PT_overlay"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012
    which = "first"

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        draw_settings(layout, context.scene, getattr(context.window_manager.penumbra_overlay, self.which))


class PENUMBRA_PT_overlay_a(_Settings):  # noqa: N801
    bl_label = "Settings of A"
    which = "first"


class PENUMBRA_PT_overlay_b(_Settings):  # noqa: N801
    bl_label = "Settings of B"
    which = "second"


_CLASSES = (PENUMBRA_PT_overlay, PENUMBRA_PT_overlay_a, PENUMBRA_PT_overlay_b)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
