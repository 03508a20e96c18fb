"""The render engine PENUMBRA: F12, animations and background renders.

Blender calls `update` with the scene locked, so the scene is read there; `render` then works without the lock, off the
main thread where there is a window. Everything that can fail ends as one sentence in Blender's reports.
"""

from __future__ import annotations

import time
from typing import Any

import bpy

from . import bridge, native, passes, picture, preferences, properties, session
from .errors import UserError
from .progress import ToldProgress
from .viewport.engine_view import EngineView

ENGINE = "PENUMBRA"


class PENUMBRA_RE_engine(bpy.types.RenderEngine):  # noqa: N801
    """Classic soft-shadow techniques."""

    bl_idname = ENGINE
    bl_label = "Penumbra"
    bl_use_preview = False  # material previews stay Blender's own
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_gpu_context = False  # OpenGL runs on the core's own thread, in its own context
    bl_use_spherical_stereo = False

    # Blender 4.4 and newer hand arguments over; they are Blender's own business.
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._export: bridge.SceneExport | None = None
        self._problem = ""
        self._view: EngineView | None = None

    def __del__(self) -> None:
        view = getattr(self, "_view", None)
        if view is not None:
            view.close()

    def update(self, data: Any = None, depsgraph: Any = None) -> None:
        """Reads the scene. What goes wrong is told by render(), where Blender listens."""
        self._export, self._problem = None, ""
        try:
            preferences.apply()
            native.load()
            self._export = bridge.read_scene(depsgraph)
        except Exception as error:
            self._problem = native.sentence(error)

    def update_render_passes(self, scene: Any = None, renderlayer: Any = None) -> None:
        self.register_pass(scene, renderlayer, passes.COMBINED, 4, "RGBA", "COLOR")
        if renderlayer is None:
            return
        if renderlayer.use_pass_z:
            self.register_pass(scene, renderlayer, picture.DEPTH, 1, "Z", "VALUE")
        if renderlayer.use_pass_normal:
            self.register_pass(scene, renderlayer, picture.NORMAL, 3, "XYZ", "VECTOR")
        if renderlayer.use_pass_position:
            self.register_pass(scene, renderlayer, picture.POSITION, 3, "XYZ", "VECTOR")
        for entry in passes.pass_list(renderlayer, passes.light_names(scene)):
            self.register_pass(scene, renderlayer, entry.name, 1, "X", "VALUE")

    def render(self, depsgraph: Any) -> None:
        export, self._export = self._export, None
        if export is None:
            self._fail(self._problem or "the scene was not read")
            return
        try:
            self._paint(export, depsgraph)
        except Exception as error:
            self._fail(native.sentence(error))

    def view_update(self, context: Any, depsgraph: Any) -> None:
        """Something in the scene changed."""
        if self._view is None:
            self._view = EngineView(self)
        self._view.update(context, depsgraph)

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        """A viewport is to be drawn: also when only its camera moved."""
        if self._view is None:
            self.view_update(context, depsgraph)
        assert self._view is not None
        self._view.draw(context, depsgraph)

    # ------------------------------------------------------------------------------------------------------------

    def _paint(self, export: bridge.SceneExport, depsgraph: Any) -> None:
        width, height = export.size
        layer = depsgraph.view_layer_eval.name
        wanted = _wanted(depsgraph)
        core = native.load()
        result = self.begin_result(0, 0, width, height, layer=layer)
        if (result.resolution_x, result.resolution_y) != (width, height):
            self.end_result(result, cancel=True)
            raise UserError(
                f"Blender wants {result.resolution_x} x {result.resolution_y} pixels, "
                f"the scene gives {width} x {height}"
            )
        stopped, made = False, None
        started = time.monotonic()
        try:
            with session.renderer(preferences.device(), preferences.view_by()) as renderer:
                progress = ToldProgress(self._tell)
                painter = picture.Painter(renderer, export, wanted, progress)
                progress.add_work(painter.work())
                for number in range(wanted.pixel_samples):
                    made = painter.sample(number)
                    _write(result, made)
                    self.update_result(result)
        except (picture.StoppedError, core.Cancelled):
            stopped = True
        except BaseException:
            self.end_result(result, cancel=True)
            raise
        self.end_result(result, cancel=stopped)
        if made is not None:
            seconds = time.monotonic() - started
            self.update_stats("", _statistics(export, wanted, made, seconds))
            for note in made.notes + made.warnings:
                self._warn(note)

    def _escaped(self) -> bool:
        return bool(self.test_break())

    def _tell(self, share: float, text: str) -> None:
        if self._escaped():
            raise picture.StoppedError
        self.update_progress(share)
        self.update_stats("", text)

    def _warn(self, note: str) -> None:
        self.report({"WARNING"}, note)

    def _fail(self, problem: str) -> None:
        # Ends an animation, and makes a background render fail instead of saving black.
        self.report({"ERROR"}, f"Penumbra: {problem}")


def _wanted(depsgraph: Any) -> picture.Wanted:
    scene, layer = depsgraph.scene, depsgraph.view_layer
    chosen = scene.penumbra
    asked = list(passes.pass_list(layer, passes.light_names(scene)))
    techniques = {chosen.technique, *(entry.technique for entry in asked if entry.technique)}
    extra = {
        name
        for name, switch in (
            (picture.DEPTH, layer.use_pass_z),
            (picture.NORMAL, layer.use_pass_normal),
            (picture.POSITION, layer.use_pass_position),
        )
        if switch
    }
    return picture.Wanted(
        technique=chosen.technique,
        settings={technique: properties.settings_of(scene, technique) for technique in techniques},
        passes=asked,
        extra=frozenset(extra),
        pixel_samples=chosen.pixel_samples,
        transparent=scene.render.film_transparent,
        keep_everything=chosen.keep_everything,
        reference_error=chosen.reference_error,
    )


def _write(result: Any, made: picture.Picture) -> None:
    layer = result.layers[0]
    for render_pass in layer.passes:
        plane = made.planes.get(render_pass.name)
        if plane is not None:
            render_pass.rect.foreach_set(plane.ravel())


def _statistics(export: bridge.SceneExport, wanted: picture.Wanted, made: picture.Picture, seconds: float) -> str:
    """One line under the picture."""
    lights = len(export.lights)
    parts = [
        f"{wanted.technique}, {lights} light{'s' if lights != 1 else ''}",
        f"{export.triangles:,} triangles",
        f"{made.samples} pixel sample{'s' if made.samples != 1 else ''}",
        f"{seconds:.2f} s",
    ]
    if made.warnings:
        parts.append(f"{len(made.warnings)} warning{'s' if len(made.warnings) != 1 else ''}")
    return " | ".join(parts)


def register() -> None:
    bpy.utils.register_class(PENUMBRA_RE_engine)


def unregister() -> None:
    bpy.utils.unregister_class(PENUMBRA_RE_engine)
