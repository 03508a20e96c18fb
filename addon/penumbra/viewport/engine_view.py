"""The render engine in a 3D viewport: what Blender shows becomes a question, the newest picture goes up."""

from __future__ import annotations

import time
import weakref
from dataclasses import replace
from typing import Any, ClassVar

from .. import errors, picture, preferences, properties
from ..read import view_region
from ..sync import SceneSync
from . import redraws
from .draw import Texture, draw_text, free_px
from .pictures import Pictures, Shown
from .times import Times
from .worker import Worker


class EngineView:
    """Lives as long as the engine of one viewport."""

    alive: ClassVar[weakref.WeakSet[EngineView]] = weakref.WeakSet()  # for measuring

    def __init__(self, engine: Any) -> None:
        self._engine = weakref.ref(engine)
        self._sync = SceneSync()
        self._worker: Worker[Shown] = Worker()
        self._pictures = Pictures()
        self._texture = Texture()
        self._revision = 0
        self._choice: tuple[Any, ...] = ()  # of objects, in the viewport that the scene was read for
        self._asked: Any = None
        self._readable = False
        self.times = Times()
        self.pictures = 0  # put up so far
        self.alive.add(self)

    @property
    def busy(self) -> bool:
        """A picture is being made."""
        return self._worker.busy

    @property
    def rests(self) -> bool:
        """Nothing is being made, and what was made is put up."""
        shown = self._worker.shown
        return not self._worker.busy and (shown is None or shown.number == self._texture.number)

    def update(self, context: Any, depsgraph: Any) -> None:
        started = time.perf_counter()
        try:
            preferences.apply()
            self._choice = view_region.own_choice(context.space_data)
            self._sync.update(depsgraph, context.space_data)
            self._readable = True
            self.times.read = time.perf_counter() - started
        except Exception as error:
            self._readable = False
            self._worker.tell_problem(errors.sentence_of(error))
        self._revision += 1

    def draw(self, context: Any, depsgraph: Any) -> None:
        if view_region.own_choice(context.space_data) != self._choice:  # Blender only draws anew
            self.update(context, depsgraph)
        started = time.perf_counter()
        seen = view_region.seen_part(context)
        if self._readable and seen is not None:
            self._ask(context, seen)
        self._put_up(context, seen)
        self.times.draw = time.perf_counter() - started

    def close(self) -> None:
        self._worker.close()
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
        self._worker.ask(
            self._pictures.question(
                key,
                replace(export, scene=export.scene.copy()),
                lambda size: seen.camera(size, points),
                (seen.box[2], seen.box[3]),
                picture.Wanted(
                    technique=chosen.technique,
                    settings={chosen.technique: settings},
                    pixel_samples=chosen.pixel_samples,
                    transparent=scene.render.film_transparent,
                    keep_everything=chosen.keep_everything,
                ),
                smaller=int(chosen.viewport_scale),
                device=preferences.device(),
                view_by=preferences.view_by(),
            )
        )
        redraws.watch(self._worker, self._redraw)

    def _redraw(self) -> None:
        engine = self._engine()
        if engine is not None:
            engine.tag_redraw()

    def _put_up(self, context: Any, seen: view_region.SeenPart | None) -> None:
        shown, problem = self._worker.shown, self._worker.problem
        if shown is not None and seen is not None:
            started = time.perf_counter()
            if self._texture.update(shown.number, shown.pixels):
                self.times.upload = time.perf_counter() - started
                self.times.core = shown.seconds
                self.pictures += 1
            self._texture.draw(seen.box)
        if problem:
            draw_text([f"Penumbra: {problem}"], free_px(context)[0] + 20.0, context.region.height / 2.0, alarm=True)
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
