"""What a click in the comparison panel does."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import bridge, catalogue, errors, native, preferences, properties
from ..compare import Options
from ..errors import UserError
from ..properties import with_properties
from ..read import view_region
from . import results, running, show, table
from .properties import group

_REFRESH_S = 0.2
_NOT_FOR_WRITING = ("flip-evaluator", "rich")  # of the libraries of `penumbra compare`

force_thread = False
"""For tests: a thread also without an event loop; collect() then has to be called by hand."""


class PENUMBRA_OT_compare(bpy.types.Operator):  # noqa: N801
    """Compare the chosen techniques with the truth, in the background. What the viewport shows is compared"""

    bl_idname = "penumbra.compare"
    bl_label = "Compare"
    bl_options = {"REGISTER"}  # noqa: RUF012  # the results push an undo step of their own when they arrive

    @classmethod
    def poll(cls, context: Any) -> bool:
        if context.scene is None:
            return False
        if not chosen_techniques(context.scene):
            cls.poll_message_set("Choose a technique to compare")
            return False
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        if running.current() is not None:
            asked = context.window_manager.invoke_confirm(
                self, event, title="Start Anew", message="A comparison is running. End it and start another one?"
            )
            return asked  # type: ignore[no-any-return]
        return self.execute(context)

    def execute(self, context: Any) -> set[str]:
        wait = bpy.app.background and not force_thread
        try:
            preferences.apply()
            order = order_of(context)
        except Exception as error:
            running.tell_problem(native.sentence(error))
            self.report({"ERROR"}, f"Penumbra: {native.sentence(error)}")
            return {"CANCELLED"}
        running.begin(order, wait=wait)
        if not wait:
            _listen()
            redraw()
            return {"FINISHED"}
        collect()
        if running.problem():
            self.report({"ERROR"}, f"Penumbra: {running.problem()}")
            return {"CANCELLED"}
        return {"FINISHED"}


class PENUMBRA_OT_compare_cancel(bpy.types.Operator):  # noqa: N801
    """End the comparison that is running; the results from before stay"""

    bl_idname = "penumbra.compare_cancel"
    bl_label = "Cancel"
    bl_options = {"REGISTER"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        if running.current() is None:
            cls.poll_message_set("No comparison is running")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        current = running.current()
        if current is not None:
            current.cancel()
        return {"FINISHED"}


class _OnResults(bpy.types.Operator):
    """Needs a comparison's results."""

    @classmethod
    def poll(cls, context: Any) -> bool:
        if context.scene is None or not context.scene.penumbra_comparison.rows:
            cls.poll_message_set("Compare first")
            return False
        return True


@with_properties(
    by=bpy.props.EnumProperty(
        name="By",
        items=[("ERROR", "Error", ""), ("TIME", "Time", ""), ("NAME", "Name", "")],
        options={"SKIP_SAVE"},
    )
)
class PENUMBRA_OT_sort_results(_OnResults):  # noqa: N801
    """Sort the table by this column; once more turns it round"""

    bl_idname = "penumbra.sort_results"
    bl_label = "Sort Results"
    bl_options = {"REGISTER", "INTERNAL"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        kept = context.scene.penumbra_comparison
        kept.sort_reverse = not kept.sort_reverse if kept.sort_by == self.by else False
        kept.sort_by = self.by
        return {"FINISHED"}


@with_properties(
    row=bpy.props.IntProperty(
        name="Row", description="Number of the result; -1 for the active one", default=-1, options={"SKIP_SAVE"}
    ),
    what=bpy.props.EnumProperty(name="What", description="Which picture", items=show.ITEMS, default="VISIBILITY"),
)
class PENUMBRA_OT_show_result(_OnResults):  # noqa: N801
    """Show this result in an image editor"""

    bl_idname = "penumbra.show_result"
    bl_label = "Show Result"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def description(cls, context: Any, given: Any) -> str:
        return f"{show.DESCRIPTIONS[given.what]} in an image editor"

    def execute(self, context: Any) -> set[str]:
        kept = context.scene.penumbra_comparison
        if 0 <= self.row < len(kept.rows):
            kept.active_row = self.row
        row = results.active(kept)
        if row is None:
            return {"CANCELLED"}
        if row.status != "ok" and self.what != "REFERENCE":
            self.report({"WARNING"}, f"{row.name} has no picture: {row.reason}")
            return {"CANCELLED"}
        try:
            image = show.image_of(kept, row, self.what)
        except UserError as error:
            self.report({"WARNING"}, str(error))
            return {"CANCELLED"}
        show.hand_to_overlay(context, row)
        if not show.put_up(context, image):
            self.report({"INFO"}, f'The picture is the image "{image.name}"')
        return {"FINISHED"}


class PENUMBRA_OT_pack_result(_OnResults):  # noqa: N801
    """Keep the shown picture in the .blend file"""

    bl_idname = "penumbra.pack_result"
    bl_label = "Pack Picture"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        if not any(image.get(show.MARK) for image in bpy.data.images):
            cls.poll_message_set("Show a result first")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        names = show.pack_all()
        self.report({"INFO"}, f"Packed {', '.join(names)}")
        return {"FINISHED"}


class PENUMBRA_OT_use_cheapest(_OnResults):  # noqa: N801
    """Render with the cheapest technique, and its settings, whose error stays within the budget at every light"""

    bl_idname = "penumbra.use_cheapest"
    bl_label = "Use Cheapest within Error"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        scene = context.scene
        kept = scene.penumbra_comparison
        found = table.cheapest(list(kept.rows), kept.target)
        if found is None:
            self.report({"WARNING"}, f"No technique stays within an error of {kept.target:g} at every light")
            return {"CANCELLED"}
        row = kept.rows[found]
        use(scene, row)
        kept.active_row = found
        self.report({"INFO"}, f"{row.name}: error {table.error_text(row.error)}")
        return {"FINISHED"}


class PENUMBRA_OT_use_result(_OnResults):  # noqa: N801
    """Render with the technique of the active row, and its settings"""

    bl_idname = "penumbra.use_result"
    bl_label = "Use This"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        if not super().poll(context):
            return False
        row = results.active(context.scene.penumbra_comparison)
        if row is None or row.status != "ok":
            cls.poll_message_set("The active row has no result")
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        use(context.scene, results.active(context.scene.penumbra_comparison))
        return {"FINISHED"}


@with_properties(
    folder=bpy.props.StringProperty(
        name="Folder",
        description="Where the report is written; empty for a folder beside the .blend file",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
)
class PENUMBRA_OT_open_report(_OnResults):  # noqa: N801
    """Write the report of the last comparison, and open it in the browser"""

    bl_idname = "penumbra.open_report"
    bl_label = "Open Report"
    bl_options = {"REGISTER"}  # noqa: RUF012

    def execute(self, context: Any) -> set[str]:
        folder = Path(bpy.path.abspath(self.folder)) if self.folder else report_folder()
        if context.window is not None:
            context.window.cursor_set("WAIT")
        try:
            page = write_report(context.scene, folder)
        except (UserError, OSError) as error:
            self.report({"ERROR"}, f"Penumbra: {errors.sentence_of(error)}")
            return {"CANCELLED"}
        finally:
            if context.window is not None:
                context.window.cursor_set("DEFAULT")
        if not bpy.app.background:
            bpy.ops.wm.url_open(url=page.as_uri())
        self.report({"INFO"}, f"Report: {page}")
        return {"FINISHED"}


# --- what they share -------------------------------------------------------------------------------------------------


def chosen_techniques(scene: Any) -> list[str]:
    chosen = scene.penumbra_comparison.techniques
    return [str(info["id"]) for info in catalogue.techniques() if getattr(chosen, info["id"])]


def order_of(context: Any) -> running.Order:
    """Reads the scene. @raises UserError, BridgeError, and what the core refuses"""
    native.load()
    scene = context.scene
    kept = scene.penumbra_comparison
    export, stated = _export(context, kept)
    lights: tuple[str, ...] = ()
    if kept.lights == "SELECTED":
        selected = {obj.name for obj in context.selected_objects if obj.type == "LIGHT"}
        lights = tuple(name for name in export.lights if name in selected)
        if not lights:
            raise UserError("no light is selected; select one, or compare at all lights")
    techniques = chosen_techniques(scene)
    options = Options(
        techniques=tuple(techniques),
        settings={technique: properties.settings_of(scene, technique) for technique in techniques},
        lights=lights,
        sweep=kept.sweep,
        reference_error=scene.penumbra.reference_error,
        target_rmse=kept.target,
        keep_everything=scene.penumbra.keep_everything,
        timing_seconds=kept.timing_seconds,
    )
    path = str(bpy.data.filepath) or "unsaved scene"
    return running.Order(export, options, path, scene.session_uid, preferences.device(), preferences.view_by(), stated)


def _export(context: Any, kept: Any) -> tuple[bridge.SceneExport, str]:
    """What the viewport shows, seen as asked for."""
    scene, depsgraph = context.scene, context.evaluated_depsgraph_get()
    if kept.view == "CAMERA":
        reader = bridge.Reader(depsgraph, depsgraph.scene_eval)
        share = scene.render.resolution_percentage / 100.0 * kept.scale / 100.0
        size = (max(1, round(scene.render.resolution_x * share)), max(1, round(scene.render.resolution_y * share)))
        export = reader.read(None, size)
        return export, export.camera
    viewport = _viewport(context)
    seen = view_region.seen_part(viewport)
    if seen is None:
        raise UserError("the 3D viewport shows nothing; compare with the scene's camera")
    reader = bridge.Reader(depsgraph, depsgraph.scene_eval, space=viewport.space_data)
    export = reader.read(None, None)
    width, height = (max(1, round(edge * kept.scale / 100.0)) for edge in seen.box[2:])
    export.scene.camera = seen.camera((width, height), reader.box_points())
    export = replace(export, camera="3D viewport", size=(width, height))
    return export, "3D viewport"


def _viewport(context: Any) -> Any:
    """The 3D viewport that the panel belongs to, or the largest one on the screen. @raises UserError without any"""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        screen = context.screen
        areas = [area for area in (screen.areas if screen is not None else ()) if area.type == "VIEW_3D"]
        if not areas or bpy.app.background:
            raise UserError("no 3D viewport is open; compare with the scene's camera")
        area = max(areas, key=lambda area: area.width * area.height)
    space = area.spaces.active
    region = next(region for region in area.regions if region.type == "WINDOW")
    return SimpleNamespace(scene=context.scene, region=region, region_data=space.region_3d, space_data=space)


def use(scene: Any, row: Any) -> None:
    properties.set_settings(scene, row.technique, json.loads(row.settings))
    scene.penumbra.technique = row.technique


def report_folder() -> Path:
    """In the folder of the preferences, else beside the .blend file, else among the temporary files."""
    name = Path(bpy.data.filepath).stem or "unsaved"
    own = preferences.preferences()
    if own is not None and own.reports:
        return Path(bpy.path.abspath(own.reports)) / name
    places = [Path(bpy.data.filepath).parent] if bpy.data.filepath else []
    for place in places:
        if os.access(place, os.W_OK):
            return place / f"{name}-penumbra"
    return Path(tempfile.gettempdir()) / "penumbra-reports" / name


def write_report(scene: Any, folder: Path) -> Path:
    """@returns the path of report.html. @raises UserError without the pictures or the libraries, OSError"""
    from .. import doctor
    from ..report import ReportWriter

    missing = [name for name in doctor.missing_libraries() if name not in _NOT_FOR_WRITING]
    if missing:
        raise UserError(f"the report needs Python packages that are not here: {', '.join(missing)}")
    kept = scene.penumbra_comparison
    comparison = results.unpacked.__wrapped__(kept.document)  # a fresh one: writing changes it
    if comparison is None:
        raise UserError("the results in this file cannot be read; compare again")
    pixels = results.pictures_of(kept)
    if pixels is None:
        raise UserError(show.MISSING)
    writer = ReportWriter(folder)
    for result in comparison.scenes:
        pixels.put_into(result)
        writer.add_scene(result)
    return writer.finish(comparison)


# --- collecting what the thread found --------------------------------------------------------------------------------


def collect() -> bool:
    """Puts what is there into its scene. @returns True while a comparison is running"""
    return running.collect(_deliver)


def _deliver(done: running.Running) -> None:
    if done.state != "done":
        return
    for scene in bpy.data.scenes:
        if scene.session_uid == done.order.scene:
            show.forget()
            results.store(scene, done)
            _push_undo()


def _push_undo() -> None:
    """So that undoing what the artist did meanwhile does not take the results away."""
    if not bpy.app.background and bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message="Penumbra Comparison")


def _listen() -> None:
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_REFRESH_S, persistent=True)


def _tick() -> float | None:
    try:
        going_on = collect()
    except Exception as error:  # a timer that raises is gone without a word
        running.tell_problem(native.sentence(error))
        going_on = False
    redraw()
    return _REFRESH_S if going_on else None


def redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "PROPERTIES"):
                for region in area.regions:
                    if region.type in ("UI", "WINDOW") and not (area.type == "VIEW_3D" and region.type == "WINDOW"):
                        region.tag_redraw()


def _follow() -> None:
    """Another row is active: an image editor that shows one of our pictures goes on to that row's."""
    try:
        show.follow(bpy.context)
    except (UserError, OSError):  # a picture that is not there: the one before stays
        return


_follower = object()  # owns the subscription


@persistent  # type: ignore[untyped-decorator]
def _subscribe(*_: Any) -> None:
    """Blender forgets subscriptions with each file. (An update function of the property would crash 4.2 at its end.)"""
    bpy.msgbus.clear_by_owner(_follower)
    bpy.msgbus.subscribe_rna(key=(group(), "active_row"), owner=_follower, args=(), notify=_follow)


@persistent  # type: ignore[untyped-decorator]
def _stop(*_: Any) -> None:
    running.stop()
    running.tell_problem("")
    show.forget()


_CLASSES = (
    PENUMBRA_OT_compare,
    PENUMBRA_OT_compare_cancel,
    PENUMBRA_OT_sort_results,
    PENUMBRA_OT_show_result,
    PENUMBRA_OT_pack_result,
    PENUMBRA_OT_use_cheapest,
    PENUMBRA_OT_use_result,
    PENUMBRA_OT_open_report,
)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_pre.append(_stop)
    if not bpy.app.background:
        bpy.app.handlers.load_post.append(_subscribe)
        _subscribe()


def unregister() -> None:
    _stop()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    bpy.msgbus.clear_by_owner(_follower)
    for handlers, handler in ((bpy.app.handlers.load_pre, _stop), (bpy.app.handlers.load_post, _subscribe)):
        if handler in handlers:
            handlers.remove(handler)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
