"""The comparison in the sidebar of the 3D viewport and among the render properties: the same panels in both places."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from typing import Any

import bpy

from .. import catalogue, verdict
from ..comparison import operators as ops
from ..comparison import pictures, results, running, show, table
from ..engine import ENGINE
from ..records import Record, Settings, settings_text
from ..report.html import format_bytes
from .settings import draw_settings

_COLUMNS = (("NAME", "Technique"), ("ERROR", "Error"), ("TIME", "Time"))
_SPLITS = (0.48, 0.5)  # of the row: the name; of what is left: the error
_GALLERY_SCALE, _PLOT_SCALE = 5.0, 12.0
_FEWEST_ROWS, _MOST_ROWS = 4, 14


class PENUMBRA_UL_results(bpy.types.UIList):  # noqa: N801
    """Techniques with their error and their time."""

    def draw_item(
        self, context: Any, layout: Any, data: Any, item: Any, icon: int, active_data: Any, active_property: str
    ) -> None:
        name, error, time = _columns(layout)
        name.label(text=item.name, icon_value=show.swatch_icon(item.colour))
        if item.status != "ok":
            error.alignment = "RIGHT"
            error.label(text=item.status)
            time.label(text="", icon="INFO")
            return
        error.alignment = time.alignment = "RIGHT"
        error.label(text=table.error_text(item.error))
        time.label(text=_milliseconds(item.time_ms))
        if item.outside:
            name.label(text="", icon="ERROR")
        if item.on_front:
            name.label(text="", icon="SOLO_ON")

    def draw_filter(self, context: Any, layout: Any) -> None:
        layout.prop(self, "filter_name", text="")

    def filter_items(self, context: Any, data: Any, property_name: str) -> tuple[list[int], list[int]]:
        flags, places = arranged(data, self.filter_name)
        return [self.bitflag_filter_item if flag else 0 for flag in flags], places


def arranged(kept: Any, wanted: str = "") -> tuple[list[bool], list[int]]:
    """Of each row: is it listed, and at which place."""
    rows = list(kept.rows)
    shown = [results.is_shown(kept, row) and wanted.casefold() in row.name.casefold() for row in rows]
    places = [0] * len(rows)
    for place, index in enumerate(table.order(rows, kept.sort_by, reverse=kept.sort_reverse)):
        places[index] = place
    return shown, places


def _columns(layout: Any) -> tuple[Any, Any, Any]:
    split = layout.split(factor=_SPLITS[0], align=True)
    name = split.row(align=True)
    rest = split.split(factor=_SPLITS[1], align=True)
    return name, rest.row(align=True), rest.row(align=True)


def _milliseconds(value: float) -> str:
    return verdict.milliseconds(value) if value >= 0.0 else "–"


# --- what the panels hold --------------------------------------------------------------------------------------------


def draw_comparison(layout: Any, context: Any) -> None:
    """What to compare, and the button."""
    kept, scene = context.scene.penumbra_comparison, context.scene
    _split(layout)
    column = layout.column()
    column.row().prop(kept, "view", expand=True)
    column.row().prop(kept, "lights", expand=True)
    column.prop(kept, "scale")
    column.prop(kept, "target")
    column.prop(scene.penumbra, "reference_error")
    column.prop(kept, "sweep")
    column.prop(kept, "timing_seconds")
    current = running.current()
    if current is None:
        row = layout.row()
        row.scale_y = 1.4
        row.operator(ops.PENUMBRA_OT_compare.bl_idname, icon="PLAY")
    else:
        share, text = current.progress
        row = layout.row(align=True)
        row.progress(factor=share, text="ending" if current.cancelled else f"{share:.0%}")
        row.operator(ops.PENUMBRA_OT_compare_cancel.bl_idname, text="", icon="X")
        note = layout.row()
        note.active = False
        note.label(text=text)
    if running.problem():
        _text(layout.box(), running.problem(), context, icon="ERROR")


def draw_techniques(layout: Any, context: Any) -> None:
    """A check and the settings of each technique."""
    _split(layout)
    chosen = context.scene.penumbra_comparison.techniques
    for info in catalogue.techniques():
        identifier = str(info["id"])
        column = layout.column(align=True)
        row = column.row(align=True)
        row.use_property_split = False
        is_open = bool(getattr(chosen, f"{identifier}_open"))
        row.prop(chosen, f"{identifier}_open", text="", icon="DOWNARROW_HLT" if is_open else "RIGHTARROW", emboss=False)
        row.prop(chosen, identifier)
        if is_open:
            draw_settings(column.box(), context.scene, identifier)


def draw_results(layout: Any, context: Any) -> None:
    """The table and what can be done with a row."""
    kept = context.scene.penumbra_comparison
    note = layout.row()
    note.active = False
    note.label(text=kept.heading)
    if len(kept.result_lights) > 1:
        layout.prop_search(kept, "shown_light", kept, "result_lights", icon="LIGHT", text="")
    head = layout.row(align=True)
    for column, (by, label) in zip(_columns(head), _COLUMNS, strict=True):
        icon = ("TRIA_UP" if kept.sort_reverse else "TRIA_DOWN") if kept.sort_by == by else "NONE"
        column.operator(ops.PENUMBRA_OT_sort_results.bl_idname, text=label, icon=icon).by = by
    rows = min(max(sum(results.is_shown(kept, row) for row in kept.rows), _FEWEST_ROWS), _MOST_ROWS)
    layout.template_list("PENUMBRA_UL_results", "", kept, "rows", kept, "active_row", rows=rows, maxrows=_MOST_ROWS)
    active = results.active(kept)
    if active is not None and active.status != "ok":
        _text(layout.box(), f"{active.name}: {active.reason}", context, icon="INFO")
    _warnings(layout, results.record_of(kept, active) if active is not None else None, context)
    if not pictures.exist(kept.key):
        _text(layout, show.MISSING, context, icon="INFO")
    grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    grid.enabled = pictures.exist(kept.key)
    for what, label, _ in show.ITEMS:
        grid.operator(ops.PENUMBRA_OT_show_result.bl_idname, text=label).what = what
    column = layout.column(align=True)
    column.operator(ops.PENUMBRA_OT_use_cheapest.bl_idname, icon="CHECKMARK")
    row = column.row(align=True)
    row.operator(ops.PENUMBRA_OT_use_result.bl_idname)
    row.operator(ops.PENUMBRA_OT_open_report.bl_idname, icon="URL")
    for sentence in results.sentences(kept):
        _text(layout, sentence, context)


def draw_thumbnails(layout: Any, context: Any) -> None:
    """All pictures side by side; a click shows one in full."""
    kept = context.scene.penumbra_comparison
    row = layout.row()
    row.prop(kept, "show_error", text="Visibility", invert_checkbox=True, toggle=True)
    row.prop(kept, "show_error", text="Error", toggle=True)
    columns = max(2, int(_width(context) / (_GALLERY_SCALE * 26)))
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)
    light = next((light for light in kept.result_lights if light.name == kept.shown_light), None)
    if light is not None and light.thumbnail and not kept.show_error:
        cell = grid.column(align=True)
        cell.template_icon(show.thumbnail_icon(light.thumbnail, error=False), scale=_GALLERY_SCALE)
        name = cell.row()
        name.alignment = "CENTER"
        name.label(text="Reference")
    for index in results.listed(kept):
        item = kept.rows[index]
        icon = show.thumbnail_icon(item.thumbnail, error=kept.show_error, colour=item.colour)
        if not icon:
            continue
        cell = grid.column(align=True)
        cell.template_icon(icon, scale=_GALLERY_SCALE)
        asked = cell.operator(
            ops.PENUMBRA_OT_show_result.bl_idname, text=item.name, emboss=False, depress=index == kept.active_row
        )
        asked.row, asked.what = index, "ERROR" if kept.show_error else "VISIBILITY"
    layout.operator(ops.PENUMBRA_OT_pack_result.bl_idname, icon="PACKAGE")


def draw_plot(layout: Any, context: Any) -> None:
    """Error against time."""
    kept = context.scene.penumbra_comparison
    layout.template_icon(show.plot_icon(kept), scale=_PLOT_SCALE)
    _text(layout, "Up: error (penumbra RMSE). Right: time of a dynamic frame. Left and low is good.", context)


def draw_row(layout: Any, context: Any) -> None:
    """What is known of the active row: why it has no result, its figures, its plan."""
    kept = context.scene.penumbra_comparison
    row = results.active(kept)
    record = results.record_of(kept, row) if row is not None else None
    if row is None or record is None:
        layout.label(text="No result is active")
        return
    layout.label(text=f"{row.name} at {row.light}", icon_value=show.swatch_icon(row.colour))
    if record.status != "ok":
        _text(layout.box(), record.reason, context, icon="INFO")
        return
    icon = show.thumbnail_icon(row.thumbnail, error=kept.show_error, colour=row.colour)
    if icon:
        layout.template_icon(icon, scale=_GALLERY_SCALE + 2)
    _pairs(layout, figures_of(record))
    if record.area is not None:
        _text(layout, str(record.area.get("sentence", "")), context)
    changed = changed_settings(record)
    _text(layout, f"Settings: {settings_text(changed)}" if changed else "All settings at their defaults", context)


def changed_settings(record: Record) -> Settings:
    """Those that are not at their defaults."""
    defaults = {str(setting["id"]): setting["default"] for setting in catalogue.technique(record.technique)["settings"]}
    return {key: value for key, value in record.settings.items() if value != defaults.get(key)}


def figures_of(record: Record) -> list[tuple[str, str]]:
    """Names and values, as the report words them."""
    area, irradiance = record.area or {}, record.irradiance or {}
    pairs = [
        ("Penumbra RMSE", table.error_text(record.headline)),
        ("RMSE", table.error_text(area.get("rmse", -1.0))),
        ("Bias", f"{area.get('bias', 0.0):+.3g}"),
        ("95 % below", table.error_text(area.get("p95", -1.0))),
        ("Largest", table.error_text(area.get("max", -1.0))),
        ("By irradiance", table.error_text(irradiance.get("penumbra_rmse", -1.0))),
    ]
    if record.flip is not None:
        pairs.append(("FLIP", table.error_text(record.flip)))
    for name, label in (
        ("dynamic", "Dynamic frame"),
        ("static", "Static frame"),
        ("kept", "Unchanged frame"),
        ("setup", "Set-up"),
    ):
        if name in record.time_ms:
            pairs.append((label, verdict.milliseconds(record.time_ms[name].median)))
    pairs.append(("Memory", format_bytes(record.memory_bytes)))
    return pairs + [(statistic.label, statistic.text()) for statistic in record.statistics]


def draw_plan(layout: Any, context: Any) -> None:
    """Steps that ran, steps that were left out, with why, and where the technique leaves its field of use."""
    kept = context.scene.penumbra_comparison
    row = results.active(kept)
    record = results.record_of(kept, row) if row is not None else None
    if record is None or not record.plan:
        layout.label(text="No result is active" if record is None else "There is no plan")
        return
    for step in record.plan:
        line = layout.split(factor=0.7, align=True)
        line.label(text=step.step, icon="CHECKBOX_HLT" if step.state == "run" else "CHECKBOX_DEHLT")
        side = line.row()
        side.alignment = "RIGHT"
        side.label(text=verdict.milliseconds(step.time_ms) if step.state == "run" else "left out")
        if step.state == "left_out":
            _text(layout, step.reason, context, indent=True)
    _warnings(layout, record, context)


def draw_notes(layout: Any, context: Any) -> None:
    """What of the scene was left out or approximated, by name."""
    notes = results.notes(context.scene.penumbra_comparison)
    if not notes:
        layout.label(text="The whole scene was taken as it is")
    for note in notes:
        _text(layout, note, context, icon="INFO")


def _warnings(layout: Any, record: Record | None, context: Any) -> None:
    """Where the technique leaves its field of use, which its plan says."""
    if record is None:
        return
    for warning in record.warnings:
        _text(layout.box(), f"{record.title}, outside its field of use: {warning}.", context, icon="ERROR")


def _split(layout: Any) -> None:
    layout.use_property_split = True
    layout.use_property_decorate = False


def _pairs(layout: Any, pairs: list[tuple[str, str]]) -> None:
    column = layout.column(align=True)
    column.scale_y = 0.85
    for name, value in pairs:
        line = column.split(factor=0.55)
        left = line.row()
        left.active = False
        left.label(text=name)
        line.label(text=value)


def _width(context: Any) -> float:
    """Of the panel, in pixels of an interface that is not enlarged."""
    width = context.region.width if context.region is not None else 300
    return float(width) / (context.preferences.system.ui_scale or 1.0)  # 0 without a window


def _text(layout: Any, text: str, context: Any, *, icon: str = "NONE", indent: bool = False) -> None:
    """Words that go on in the next line where the panel ends."""
    letters = max(20, int((_width(context) - (60 if icon != "NONE" or indent else 40)) / 6.2))
    column = layout.column(align=True)
    column.scale_y = 0.75
    for number, line in enumerate(textwrap.wrap(text, letters)):
        first = icon if number == 0 else ("BLANK1" if icon != "NONE" or indent else "NONE")
        column.label(text=line, icon="BLANK1" if indent else first)


# --- the panels, twice -----------------------------------------------------------------------------------------------

Draw = Callable[[Any, Any], None]

_PANELS: tuple[tuple[str, str, Draw, str, bool, bool], ...] = (
    # name, label, draw, parent, closed at first, needs results
    ("comparison", "Comparison", draw_comparison, "", False, False),
    ("compared_techniques", "Techniques", draw_techniques, "comparison", True, False),
    ("results", "Results", draw_results, "", False, True),
    ("plot", "Error versus Time", draw_plot, "results", False, True),
    ("thumbnails", "Thumbnails", draw_thumbnails, "results", True, True),
    ("result", "Statistics", draw_row, "results", True, True),
    ("plan", "What Was Left Out", draw_plan, "results", True, True),
    ("notes", "Notes on the Scene", draw_notes, "results", True, True),
)


def _poll(in_properties: bool, needs_results: bool) -> Any:
    def poll(cls: Any, context: Any) -> bool:
        if in_properties and context.engine != ENGINE:
            return False
        return bool(context.scene is not None and (not needs_results or context.scene.penumbra_comparison.rows))

    return classmethod(poll)


def _panel(prefix: str, place: dict[str, Any], entry: tuple[str, str, Draw, str, bool, bool]) -> type:
    name, label, draw, parent, closed, needs_results = entry
    content: dict[str, Any] = dict(place) | {
        "__doc__": draw.__doc__,
        "bl_label": label,
        "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
        "poll": _poll(place["bl_space_type"] == "PROPERTIES", needs_results),
        "draw": lambda self, context: draw(self.layout, context),
    }
    if parent:
        content["bl_parent_id"] = f"PENUMBRA_PT_{prefix}{parent}"
    return type(f"PENUMBRA_PT_{prefix}{name}", (bpy.types.Panel,), content)


_SIDEBAR = {"bl_space_type": "VIEW_3D", "bl_region_type": "UI", "bl_category": "Penumbra"}
_RENDER = {"bl_space_type": "PROPERTIES", "bl_region_type": "WINDOW", "bl_context": "render"}

_CLASSES: tuple[type, ...] = (
    PENUMBRA_UL_results,
    *(_panel("", _SIDEBAR, entry) for entry in _PANELS),
    *(_panel("render_", _RENDER | {"COMPAT_ENGINES": {ENGINE}}, entry) for entry in _PANELS),
)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    show.forget()
