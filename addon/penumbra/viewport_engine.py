"""The render engine in a 3D viewport: what Blender shows becomes a question, the newest picture goes up."""

from __future__ import annotations

import weakref
from dataclasses import replace
from typing import Any

from . import errors, picture, preferences, properties, viewport
from .read import view_region
from .sync import SceneSync
from .viewport_draw import Texture, draw_text


class ViewportEngine:
    """Lives as long as the engine of one viewport."""

    def __init__(self, engine: Any) -> None:
        # The viewport's thread must not keep Blender's engine alive, nor speak to one that is gone.
        told = weakref.ref(engine)

        def redraw() -> None:
            alive = told()
            if alive is not None:
                alive.tag_redraw()

        self._engine = told
        self._sync = SceneSync()
        self._viewport = viewport.Viewport(redraw)
        self._texture = Texture()
        self._revision = 0
        self._asked: Any = None
        self._readable = False

    def update(self, context: Any, depsgraph: Any) -> None:
        try:
            preferences.apply()
            self._sync.update(depsgraph)
            self._readable = True
        except Exception as error:
            self._readable = False
            self._viewport.tell_problem(errors.sentence_of(error))
        self._revision += 1

    def draw(self, context: Any, depsgraph: Any) -> None:
        seen = view_region.seen_part(context)
        if self._readable and seen is not None:
            self._ask(context, seen)
        self._put_up(context, seen)

    def close(self) -> None:
        self._viewport.close()
        self._texture.free()

    def _ask(self, context: Any, seen: view_region.SeenPart) -> None:
        scene = context.scene
        chosen = scene.penumbra
        settings = properties.settings_of(scene, chosen.technique)
        key = (
            self._revision,
            seen.key,
            chosen.technique,
            tuple(settings.items()),
            chosen.pixel_samples,
            chosen.keep_everything,
            scene.render.film_transparent,
        )
        if key == self._asked:
            return
        export = self._sync.export
        assert export is not None
        points = self._sync.box_points
        self._asked = key
        self._viewport.ask(
            viewport.Question(
                key=key,
                export=replace(export, scene=export.scene.copy()),
                camera=lambda size: seen.camera(size, points),
                size=(seen.box[2], seen.box[3]),
                wanted=picture.Wanted(
                    technique=chosen.technique,
                    settings={chosen.technique: settings},
                    pixel_samples=chosen.pixel_samples,
                    transparent=scene.render.film_transparent,
                    keep_everything=chosen.keep_everything,
                ),
                smaller=int(chosen.viewport_scale),
                device=preferences.device(),
            )
        )

    def _put_up(self, context: Any, seen: view_region.SeenPart | None) -> None:
        shown, problem = self._viewport.shown, self._viewport.problem
        if shown is not None and seen is not None:
            self._texture.update(shown.number, shown.pixels)
            self._texture.draw(seen.box)
        if problem:
            draw_text([f"Penumbra: {problem}"], 20.0, context.region.height / 2.0, alarm=True)
        engine = self._engine()
        if engine is None:
            return
        if problem:
            engine.update_stats("Penumbra", problem)
        elif shown is not None:
            size = f"{shown.size[0]} x {shown.size[1]}"
            milliseconds = f"{1e3 * shown.seconds:.0f} ms"
            words = [context.scene.penumbra.technique, size, milliseconds, *shown.notes]
            engine.update_stats("Penumbra", " | ".join(words))
