"""The overlay: a wipe between two pictures on top of whatever engine draws the viewport.

While it is off there is no handler, no thread and no renderer.
"""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import catalogue, colours, errors, preferences, properties
from ..read import view_region
from ..sync import SceneSync
from . import redraws
from .draw import Texture, draw_bar, draw_ramp, draw_text, free_px, scissored
from .overlay_pictures import ERROR, ERROR_OTHER, REFERENCE, Compared, Comparisons, Wanted
from .times import Times
from .worker import Worker

_TITLE_PX = 14.0
_GRIP_PX = 8  # how near the wipe line counts as on it


@dataclass
class _Region:
    """What the overlay keeps for one region of one viewport."""

    worker: Worker[Compared]
    comparisons: Comparisons = field(default_factory=Comparisons)
    left: Texture = field(default_factory=Texture)
    right: Texture = field(default_factory=Texture)
    asked: Any = None
    cursor: tuple[int, int] | None = None  # pixels of the region
    times: Times = field(default_factory=Times)

    @property
    def rests(self) -> bool:
        shown = self.worker.shown
        return not self.worker.busy and (shown is None or shown.number == self.left.number)

    def close(self) -> None:
        self.worker.close()
        self.left.free()
        self.right.free()


class _Scene:
    """The scene as viewports show it: as its view layer has it, or as one viewport has it that hides something."""

    def __init__(self) -> None:
        self.sync = SceneSync()
        self.choice: tuple[Any, ...] | None = None  # of objects, in that one viewport; None before the first read
        self.problem = ""
        self.revision = 0  # no two reads have the same

    def read(self, depsgraph: Any, space: Any | None) -> None:
        """@param space the one viewport whose choice counts"""
        self.choice = view_region.own_choice(space)
        self.revision = next(_state.revisions)
        try:
            self.sync.update(depsgraph, space)
            self.problem = ""
        except Exception as error:
            self.problem = errors.sentence_of(error)


_Key = tuple[int, int]  # pointers: of the view layer, and of the viewport if it hides something


class _State:
    """Of the one overlay of this Blender."""

    def __init__(self) -> None:
        self.handle: Any = None
        self.regions: dict[int, _Region] = {}
        self.scenes: dict[_Key, _Scene] = {}
        self.revisions = itertools.count(1)
        self.chosen = ""

    @property
    def on(self) -> bool:
        return self.handle is not None


_state = _State()


# ------------------------------------------------------------------------------------------------------- properties


def _sides(_group: Any = None, _context: Any = None) -> list[tuple[str, str, str]]:
    return [
        ("A", "A", "The first technique"),
        ("B", "B", "The second technique"),
        (REFERENCE, "Truth", "Ray traced; it takes a moment after the view rests"),
        (ERROR, "Error of A", "How far A is from the truth, in false colours"),
        (ERROR_OTHER, "Error of B", "How far B is from the truth, in false colours"),
    ]


@properties.with_properties(
    first=bpy.props.EnumProperty(
        name="A", description="The first technique", items=properties.technique_items(), default="shadow_map"
    ),
    second=bpy.props.EnumProperty(
        name="B", description="The second technique", items=properties.technique_items(), default="ray_traced"
    ),
    left=bpy.props.EnumProperty(
        name="Left", description="What stands left of the wipe line", items=_sides(), default="A"
    ),
    right=bpy.props.EnumProperty(
        name="Right", description="What stands right of the wipe line", items=_sides(), default="B"
    ),
    wipe=bpy.props.FloatProperty(
        name="Wipe", description="Where the line stands, from left to right", default=0.5, min=0.0, max=1.0,
        subtype="FACTOR",
    ),
    shaded=bpy.props.BoolProperty(
        name="Shaded", description="Show shaded pictures; else visibility as grey, 1 white", default=True
    ),
    light=bpy.props.StringProperty(
        name="Light", description="Name of the one light to look at; empty for all lights together", default=""
    ),
    error_scale=bpy.props.FloatProperty(
        name="Error Scale", description="The error that the brightest false colour stands for", default=0.5,
        min=0.001, max=1.0, precision=3,
    ),
    reference_error=bpy.props.FloatProperty(
        name="Truth's Error", description="Standard error of the ray-traced truth in the overlay", default=0.02,
        min=0.001, max=0.2, precision=3,
    ),
)  # fmt: skip
class PENUMBRA_PG_overlay(bpy.types.PropertyGroup):  # noqa: N801
    """What the overlay shows; of this Blender, not of the file."""


# -------------------------------------------------------------------------------------------------------- on and off


def is_on() -> bool:
    return _state.on


def rests() -> bool:
    """It is on, nothing is being made, and what was made is put up: for tests."""
    return _state.on and bool(_state.regions) and all(region.rests for region in _state.regions.values())


def switch_on(context: Any) -> None:
    """The viewports' scenes are read when they are drawn."""
    if _state.on:
        return
    preferences.apply()
    _state.handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")
    for handlers, function in _handlers():
        handlers.append(function)
    _redraw_all()


def switch_off() -> None:
    """Leaves nothing behind; called also where it is off already."""
    if _state.handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_state.handle, "WINDOW")
        _state.handle = None
    for handlers, function in _handlers():
        with contextlib.suppress(ValueError):
            handlers.remove(function)
    for region in _state.regions.values():
        region.close()
    _state.regions.clear()
    _state.scenes.clear()
    _redraw_all()


def _handlers() -> list[tuple[Any, Any]]:
    app = bpy.app.handlers
    return [(app.depsgraph_update_post, _changed), (app.load_pre, _loading), (app.undo_post, _undone),
            (app.redo_post, _undone)]  # fmt: skip


def _viewports() -> Iterator[tuple[Any, Any]]:
    """Each 3D viewport that is open, with its window."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                yield window, area


def _redraw_all() -> None:
    for _, area in _viewports():
        area.tag_redraw()


def _key(view_layer: Any, space: Any) -> _Key:
    return view_layer.as_pointer(), space.as_pointer() if view_region.hides_something(space) else 0


@persistent  # type: ignore[untyped-decorator]
def _changed(_scene: Any, depsgraph: Any = None) -> None:
    """What is shown follows; what no viewport shows any more goes."""
    if depsgraph is None or depsgraph.mode != "VIEWPORT":
        return
    shown: dict[_Key, Any] = {}
    regions: set[int] = set()
    for window, area in _viewports():
        space = area.spaces.active
        key = _key(window.view_layer, space)
        shown[key] = space if key[1] else None
        regions |= {region.as_pointer() for region in area.regions}
    for number in _state.regions.keys() - regions:
        _state.regions.pop(number).close()
    layer = depsgraph.view_layer.as_pointer()
    for key in list(_state.scenes):
        if key not in shown:
            del _state.scenes[key]
        elif key[0] == layer:
            _state.scenes[key].read(depsgraph, shown[key])


def _scene_of(context: Any) -> _Scene:
    """As the viewport that is drawn shows it: Blender only draws anew when a viewport hides something else."""
    space = context.space_data
    key = layer, own = _key(context.view_layer, space)
    if not own:
        _state.scenes.pop((layer, space.as_pointer()), None)  # of a local view that was left
    scene = _state.scenes.setdefault(key, _Scene())
    one = space if own else None
    if scene.choice != view_region.own_choice(one):
        scene.read(context.view_layer.depsgraph, one)
    return scene


@persistent  # type: ignore[untyped-decorator]
def _loading(*_: Any) -> None:
    switch_off()


@persistent  # type: ignore[untyped-decorator]
def _undone(*_: Any) -> None:
    """Undo exchanges Blender's data: what is kept of it is worth nothing."""
    _state.scenes.clear()


# ----------------------------------------------------------------------------------------------------------- drawing


def notice(context: Any) -> None:
    """A choice in the sidebar redraws the sidebar alone: the viewports follow."""
    chosen = repr(_wanted(context))
    if is_on() and chosen != _state.chosen:
        _state.chosen = chosen
        _redraw_all()


def region_state(context: Any) -> _Region | None:
    return _state.regions.get(context.region.as_pointer()) if context.region is not None else None


def wipe_px(context: Any) -> int:
    return int(context.window_manager.penumbra_overlay.wipe * context.region.width + 0.5)


def on_wipe(context: Any, x_px: float) -> bool:
    return abs(x_px - wipe_px(context)) <= _GRIP_PX


def _draw() -> None:
    context = bpy.context
    try:
        _draw_region(context)
    except Exception as error:  # a drawing handler that raises would fill the console for ever
        draw_text([f"Penumbra: {errors.sentence_of(error)}"], 20.0, context.region.height / 2.0, alarm=True)


def _draw_region(context: Any) -> None:
    started = time.perf_counter()
    seen = view_region.seen_part(context)
    if seen is None:
        return
    key = context.region.as_pointer()
    kept = _state.regions.get(key)
    if kept is None:
        kept = _state.regions[key] = _Region(Worker())
    scene = _scene_of(context)
    if not scene.problem:
        _ask(context, kept, seen, scene)
    shown, problem = kept.worker.shown, kept.worker.problem or scene.problem
    if shown is not None:
        _draw_sides(context, kept, shown, seen.box)
    elif not problem:
        draw_text(["Penumbra: the first pictures are being made ..."], free_px(context)[0] + 20.0, 60.0)
    if problem:
        draw_text([f"Penumbra: {problem}"], free_px(context)[0] + 20.0, context.region.height / 2.0, alarm=True)
    kept.times.draw = time.perf_counter() - started


def _wanted(context: Any) -> Wanted:
    chosen = context.window_manager.penumbra_overlay
    sides = {"A": chosen.first, "B": chosen.second}
    techniques = (chosen.first, chosen.second)
    return Wanted(
        techniques=techniques,
        settings={technique: properties.settings_of(context.scene, technique) for technique in techniques},
        left=sides.get(chosen.left, chosen.left),
        right=sides.get(chosen.right, chosen.right),
        light=chosen.light,
        shaded=chosen.shaded,
        error_scale=chosen.error_scale,
        reference_error=chosen.reference_error,
    )


def _ask(context: Any, kept: _Region, seen: view_region.SeenPart, scene: _Scene) -> None:
    wanted = _wanted(context)
    key = (scene.revision, seen.key, repr(wanted))
    if key == kept.asked:
        return
    export = scene.sync.export
    assert export is not None
    points = scene.sync.box_points
    titles = {info["id"]: info["title"] for info in catalogue.techniques()}
    kept.asked = key
    kept.worker.ask(
        kept.comparisons.question(
            key,
            replace(export, scene=export.scene.copy()),
            lambda size: seen.camera(size, points),
            (seen.box[2], seen.box[3]),
            wanted,
            titles,
            smaller=int(context.scene.penumbra.viewport_scale),
            device=preferences.device(),
            view_by=preferences.view_by(),
        )
    )
    redraws.watch(kept.worker, _redraw_all)


def _draw_sides(context: Any, kept: _Region, shown: Compared, box: tuple[int, int, int, int]) -> None:
    region = context.region
    started = time.perf_counter()
    if kept.left.update(shown.number, shown.left) and kept.right.update(shown.number, shown.right):
        kept.times.upload = time.perf_counter() - started
    line = wipe_px(context)
    with scissored(region, 0, 0, line, region.height):
        kept.left.draw(box, on_display=True)
    with scissored(region, line, 0, region.width - line, region.height):
        kept.right.draw(box, on_display=True)
    draw_bar(line, 0, 1, region.height, (1.0, 1.0, 1.0, 0.9))
    draw_bar(line - 3, region.height // 2 - 18, 7, 36, (1.0, 1.0, 1.0, 0.9))
    top = float(region.height) - 60.0
    draw_text([shown.titles[0]], max(12.0, line - 12.0), top, size=_TITLE_PX, right=True)
    draw_text([shown.titles[1]], line + 12.0, top, size=_TITLE_PX)
    chosen = context.window_manager.penumbra_overlay
    left, right = free_px(context)
    if {chosen.left, chosen.right} & {ERROR, ERROR_OTHER}:
        _draw_legend(right, chosen.error_scale)
    lines = _figures(kept, shown, box)
    if shown.reference is None and {chosen.left, chosen.right} & {ERROR, ERROR_OTHER, REFERENCE}:
        lines.append("The truth is being traced ...")
    lines += shown.notes
    draw_text(lines, left + 20.0, 40.0 + 1.4 * 13.0 * len(lines))


def _figures(kept: _Region, shown: Compared, box: tuple[int, int, int, int]) -> list[str]:
    if kept.cursor is None:
        return []
    left, bottom, width, height = box
    figures = shown.at((kept.cursor[0] - left) / width, (kept.cursor[1] - bottom) / height)
    if not figures:
        return []
    return [
        "   ".join(f"{name} {value:+.3f}" if "-" in name else f"{name} {value:.3f}" for name, value in figures.items())
    ]


def _draw_legend(end: int, scale: float) -> None:
    width, height = 256, 10
    left, bottom = end - width - 24, 40
    stops = [(r / 255.0, g / 255.0, b / 255.0, 1.0) for r, g, b in colours.stops("inferno").tolist()]
    draw_ramp(left, bottom, width, height, stops)
    draw_text(["0"], left, bottom - 2.0, size=11.0)
    draw_text([f"{scale:g} and more"], float(left + width), bottom - 2.0, size=11.0, right=True)


# ------------------------------------------------------------------------------------------------------ registration


class PENUMBRA_OT_overlay(bpy.types.Operator):  # noqa: N801
    """Show two shadow techniques, the truth or an error over the viewport, with a line between them to drag"""

    bl_idname = "penumbra.overlay"
    bl_label = "Penumbra Overlay"
    bl_options = {"REGISTER"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        if bpy.app.background:
            cls.poll_message_set("the overlay needs a window")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        if is_on():
            switch_off()
        else:
            switch_on(context)
        return {"FINISHED"}


class PENUMBRA_GT_wipe(bpy.types.Gizmo):  # noqa: N801
    """The line between the two pictures: follows the mouse while it is held, and knows where the mouse is."""

    bl_idname = "PENUMBRA_GT_wipe"

    def setup(self) -> None:
        self.use_draw_modal = True

    def draw(self, context: Any) -> None:
        """The overlay draws the line with the pictures."""

    def test_select(self, context: Any, location: Any) -> int:
        kept = region_state(context)
        if kept is not None:
            kept.cursor = (int(location[0]), int(location[1]))
            context.area.tag_redraw()
        return 0 if on_wipe(context, location[0]) else -1

    def invoke(self, context: Any, event: Any) -> set[str]:
        self._before = context.window_manager.penumbra_overlay.wipe
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any, tweak: Any) -> set[str]:
        region = context.region
        share = (event.mouse_x - region.x) / max(region.width, 1)
        context.window_manager.penumbra_overlay.wipe = min(max(share, 0.0), 1.0)
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def exit(self, context: Any, cancel: bool) -> None:
        if cancel:
            context.window_manager.penumbra_overlay.wipe = self._before
        context.area.tag_redraw()


class PENUMBRA_GGT_wipe(bpy.types.GizmoGroup):  # noqa: N801
    bl_idname = "PENUMBRA_GGT_wipe"
    bl_label = "Penumbra wipe"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT", "SHOW_MODAL_ALL"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        return is_on()

    def setup(self, context: Any) -> None:
        self.gizmos.new(PENUMBRA_GT_wipe.bl_idname)


_CLASSES = (PENUMBRA_PG_overlay, PENUMBRA_OT_overlay, PENUMBRA_GT_wipe, PENUMBRA_GGT_wipe)
_keys: list[tuple[Any, Any]] = []


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.penumbra_overlay = bpy.props.PointerProperty(type=PENUMBRA_PG_overlay)
    if bpy.app.background:
        return
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is not None:
        keymap = configuration.keymaps.new(name="3D View", space_type="VIEW_3D")
        item = keymap.keymap_items.new(PENUMBRA_OT_overlay.bl_idname, "W", "PRESS", ctrl=True, alt=True)
        _keys.append((keymap, item))


def unregister() -> None:
    switch_off()
    while _keys:
        keymap, item = _keys.pop()
        keymap.keymap_items.remove(item)
    del bpy.types.WindowManager.penumbra_overlay
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
