"""Does one item: reads its scene at its frame, compares or renders, and puts the result in its place."""

from __future__ import annotations

import datetime
import os
import resource
import signal
import socket
import sys
import time
from pathlib import Path
from typing import Any

from .. import compare, environment, native, render, scenes, together
from ..commands.scene import make_renderer, read_view
from ..errors import UserError
from ..progress import Progress
from ..records import Comparison
from ..report import ReportWriter
from .jobs import Item
from .store import Document, Facts, Store, core_digest, made_from

CRASH = "PENUMBRA_TEST_CRASH"
"""For tests: ITEM or ITEM@FILE. A worker dies of a segmentation fault at that item; with a file, only while that is
there, and takes it away."""


class Workbench:
    """What a worker keeps between items: the renderer, the scene that is open, and the hashes of files."""

    def __init__(self) -> None:
        self._core = native.load()
        self._renderers: dict[tuple[str, str], Any] = {}  # by device and view
        self._facts = Facts()
        self._open: Document | None = None

    def do(self, item: Item, out: Path, core: str, workers: int, progress: Progress) -> Document:
        """@return item.json; the result is in its place.

        core: digest of the build that the batch was started with; workers: how many share this machine

        @raises UserError for what will not be better next time, anything else for what might
        """
        if core != core_digest():
            raise UserError(
                f"the core here ({core_digest()}) is not the one that the batch was started with ({core}); "
                "install the same Penumbra on all machines"
            )
        _crash_if_asked(item)
        started = time.monotonic()
        machine = (item.device, item.view_by)
        if machine not in self._renderers:
            self._renderers[machine] = make_renderer(self._core, *machine)
        renderer = self._renderers[machine]
        progress.stage("reading", 0.0)
        export, files = self._read(item)
        store = Store(out)
        with store.workplace() as place, compare.core_errors(self._core):
            make = self._compare if item.mode == "compare" else self._render
            made, failures, notes = make(item, export, renderer, place, progress)
            document = {
                "schema": 1,
                "item": item.id,
                "scene": item.scene,
                "camera": export.camera,
                "frame": export.frame,
                "made_from": made_from(item, files),
                "failures": failures,
                "notes": notes,
                "seconds": round(time.monotonic() - started, 3),
                "memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
                "workers": workers,
                "host": socket.gethostname(),
                "date": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
            }
            store.commit(item, made, document)
        return document

    def _read(self, item: Item) -> tuple[Any, list[Document]]:
        """The scene at the item's frame, and the facts of all files it was read from. A scene whose frames follow one
        another stays open."""
        path = Path(item.scene)
        try:
            facts = self._facts.of(path)
        except OSError as error:
            raise UserError(f'the scene "{path}" cannot be read: {(error.strerror or str(error)).lower()}') from error
        again = facts == self._open
        self._open = None
        export = read_view(self._core, None if again else path, camera=item.camera, size=item.size, frame=item.frame)
        self._open = facts
        return export, [facts, *self._others(path)]

    def _others(self, scene: Path) -> list[Document]:
        """Libraries, caches and images that the scene refers to."""
        bpy = scenes.import_bpy()
        if scene.suffix.lower() != ".blend":
            return []
        found = []
        for name in sorted({os.path.normpath(name) for name in bpy.utils.blend_paths(absolute=True)}):
            path = Path(name)
            if path.is_file() and path != scene:
                found.append(self._facts.of(path))
        return found

    def _compare(
        self, item: Item, export: Any, renderer: Any, place: Path, progress: Progress
    ) -> tuple[Path, list[Document], list[str]]:
        folder = place / "result"
        comparer = compare.Comparer(self._core, renderer, item.options, progress)
        progress.add_work(comparer.work(len(item.options.lights) or len(export.lights)))
        scene = comparer.compare(export, item.scene)
        comparison = Comparison(environment={}, options=_recorded(item), scenes=[scene], failures=comparer.failures)
        together.summarise(comparison, item.options.target_rmse)
        writer = ReportWriter(folder)
        writer.add_scene(scene)
        comparison.environment = environment.collect(self._core, renderer, item.arguments())
        writer.finish(comparison)
        return folder, [{"what": each.what, "reason": each.reason} for each in comparer.failures], list(export.notes)

    def _render(
        self, item: Item, export: Any, renderer: Any, place: Path, progress: Progress
    ) -> tuple[Path, list[Document], list[str]]:
        options = item.options
        progress.add_work(render.work(export))
        frame = render.render(
            renderer,
            export,
            item.technique,
            options.settings.get(item.technique, {}),
            compare.choose_lights(list(export.lights), options.lights),
            progress,
            keep_everything=options.keep_everything,
        )
        path = place / f"picture.{item.format}"
        frame.write(path)
        return path, [], [*export.notes, *frame.notes, *frame.warnings]


def _recorded(item: Item) -> dict[str, Any]:
    options = item.options
    return {
        "sweep": options.sweep,
        "reference_error": options.reference_error,
        "target_rmse": options.target_rmse,
        "timing_seconds": options.timing_seconds,
        "warn_rmse": item.warn_rmse,
        "fail_rmse": item.fail_rmse,
        "keep_everything": options.keep_everything,
        "measure_savings": options.measure_savings,
    }


def _crash_if_asked(item: Item) -> None:
    wanted, _, file = os.environ.get(CRASH, "").partition("@")
    if wanted != item.id:
        return
    if file:
        try:
            os.unlink(file)
        except FileNotFoundError:
            return
    print(f"{CRASH}: dying at {item.id}", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGSEGV)
