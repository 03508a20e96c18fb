"""Render and view layer properties of the engine."""

from __future__ import annotations

from typing import Any

import bpy

from .. import catalogue
from ..engine import ENGINE
from .settings import draw_settings

# Blender's own panels that mean something to us, by the names they have had since 4.2.
_OURS_TOO = (
    "RENDER_PT_format", "RENDER_PT_format_presets", "RENDER_PT_frame_range", "RENDER_PT_time_stretching",
    "RENDER_PT_output", "RENDER_PT_output_views", "RENDER_PT_output_color_management", "RENDER_PT_encoding",
    "RENDER_PT_post_processing", "RENDER_PT_stamp", "RENDER_PT_stamp_note", "RENDER_PT_stamp_burn",
    "RENDER_PT_color_management", "RENDER_PT_color_management_curves", "RENDER_PT_color_management_display_settings",
    "RENDER_PT_color_management_white_balance", "RENDER_PT_color_management_working_space",
    "DATA_PT_context_light", "DATA_PT_light", "DATA_PT_area", "DATA_PT_spot", "DATA_PT_custom_props_light",
    "EEVEE_MATERIAL_PT_context_material", "MATERIAL_PT_viewport", "MATERIAL_PT_preview",
    "WORLD_PT_context_world", "WORLD_PT_viewport_display",
    "DATA_PT_lens", "DATA_PT_camera", "DATA_PT_context_camera", "DATA_PT_camera_display",
    "DATA_PT_camera_background_image", "DATA_PT_camera_safe_areas", "DATA_PT_custom_props_camera",
    "DATA_PT_context_mesh", "DATA_PT_customdata", "DATA_PT_vertex_groups", "DATA_PT_shape_keys", "DATA_PT_uv_texture",
    "DATA_PT_vertex_colors", "DATA_PT_custom_props_mesh", "DATA_PT_normals",
    "OBJECT_PT_visibility", "TEXTURE_PT_context",
    "VIEWLAYER_PT_layer", "VIEWLAYER_PT_filter",
)  # fmt: skip


class _Panel(bpy.types.Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine in cls.COMPAT_ENGINES


class PENUMBRA_PT_technique(_Panel):  # noqa: N801
    bl_label = "Technique"

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        chosen = context.scene.penumbra
        layout.prop(chosen, "technique")
        info = catalogue.technique(chosen.technique)
        box = layout.column(align=True)
        box.active = False
        for line in _lines(str(info["summary"]), context.region.width):
            box.label(text=line)


class PENUMBRA_PT_technique_settings(_Panel):  # noqa: N801
    bl_label = "Settings"
    bl_parent_id = "PENUMBRA_PT_technique"

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        draw_settings(layout, context.scene, context.scene.penumbra.technique)


class PENUMBRA_PT_sampling(_Panel):  # noqa: N801
    bl_label = "Sampling"

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        chosen = context.scene.penumbra
        layout.prop(chosen, "pixel_samples")
        layout.prop(chosen, "viewport_scale")
        layout.prop(chosen, "reference_error")
        layout.prop(chosen, "keep_everything")


class PENUMBRA_PT_film(_Panel):  # noqa: N801
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(context.scene.render, "film_transparent", text="Transparent")


class PENUMBRA_PT_passes(_Panel):  # noqa: N801
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layer, chosen = context.view_layer, context.view_layer.penumbra
        column = layout.column(heading="Data")
        column.prop(layer, "use_pass_z", text="Depth")
        column.prop(layer, "use_pass_normal", text="Normal")
        column.prop(layer, "use_pass_position", text="Position")
        column = layout.column()
        column.label(text="Visibility")
        flow = column.grid_flow(columns=2, even_columns=True, align=True)
        flow.use_property_split = False
        flow.prop(chosen, "visibility", expand=True)
        column = layout.column()
        column.prop(chosen, "use_reference")
        sub = column.column()
        sub.active = bool(chosen.visibility)
        sub.prop(chosen, "use_error")
        column.prop(chosen, "per_light")


def _lines(text: str, width_px: int) -> list[str]:
    import textwrap

    return textwrap.wrap(text, max(24, width_px // 8))


_CLASSES = (
    PENUMBRA_PT_technique,
    PENUMBRA_PT_technique_settings,
    PENUMBRA_PT_sampling,
    PENUMBRA_PT_film,
    PENUMBRA_PT_passes,
)
_joined: list[type] = []


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for name in _OURS_TOO:
        panel = getattr(bpy.types, name, None)
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if isinstance(engines, set) and ENGINE not in engines:
            engines.add(ENGINE)
            _joined.append(panel)  # type: ignore[arg-type]


def unregister() -> None:
    while _joined:
        _joined.pop().COMPAT_ENGINES.discard(ENGINE)  # type: ignore[attr-defined]
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
