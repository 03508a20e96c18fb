"""What users of render add-ons complain of: an add-on is a guest in Blender, beside others and beside itself."""

from __future__ import annotations

import gc
import itertools
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import penumbra
import penumbra_core as core
import pytest
from blender_kit import Kit
from penumbra import bridge, picture
from penumbra.viewport.pictures import Pictures
from penumbra.viewport.worker import Worker

SIZE = (40, 24)


def handlers() -> dict[str, list[Any]]:
    """All that Blender calls by itself."""
    lists = {name: getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers)}
    return {name: list(value) for name, value in lists.items() if isinstance(value, list)}


def furnished(kit: Kit) -> Kit:
    kit.plane("Floor", half=5)
    kit.cube("Box", half=0.5, at=(0, 0, 1))
    kit.light("POINT", name="Key", energy=100, at=(1, 0, 4), shadow_soft_size=0.4)
    kit.camera(at=(0, 0, 9))
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = SIZE
    kit.scene.render.resolution_percentage = 100
    bpy.context.view_layer.update()
    return kit


def test_switched_on_and_unused_it_is_called_by_nothing_that_happens_often(kit: Kit) -> None:
    """Merely enabling other add-ons slows scenes of thousands of objects."""
    often = ("depsgraph_update", "frame_change", "render_", "translation", "animation", "composite", "annotation")
    before, draws = handlers(), bpy.app.timers
    penumbra.register()
    try:
        after = handlers()
        for name, functions in after.items():
            if name.startswith(often):
                assert functions == before.get(name, []), name
        from penumbra.viewport import redraws

        assert not draws.is_registered(redraws._look)
    finally:
        penumbra.unregister()
    assert handlers() == before


def test_a_second_copy_is_refused_in_a_sentence_and_the_first_goes_on(addon: Kit, tmp_path: Path) -> None:
    """As an extension beside the pip package, or an old installation beside the new."""
    copy = tmp_path / "penumbra_again"
    shutil.copytree(Path(penumbra.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    sys.path.insert(0, str(tmp_path))
    try:
        import penumbra_again  # type: ignore[import-not-found]

        from_copy = sys.modules["penumbra_again"]
        with pytest.raises(Exception, match=r"another copy of Penumbra is switched on: penumbra in .*; switch one"):
            from_copy.register()
        furnished(addon)
        assert bpy.ops.render.render() == {"FINISHED"}
        penumbra.unregister()
        penumbra_again.register()
        penumbra_again.unregister()
    finally:
        sys.path.remove(str(tmp_path))
        for name in [name for name in sys.modules if name.split(".")[0] == "penumbra_again"]:
            del sys.modules[name]
        penumbra.register()  # the fixture switches it off
    assert bpy.ops.render.render() == {"FINISHED"}


def test_other_threads_of_python_go_on_while_the_core_works(addon: Kit, monkeypatch: pytest.MonkeyPatch) -> None:
    """A render of hours ends because another thread says so: it could not if the core kept the interpreter."""
    from penumbra import engine

    furnished(addon)
    addon.scene.penumbra.technique = "ray_traced"
    addon.scene.penumbra.settings.ray_traced.rays = 65536
    addon.scene.render.resolution_x, addon.scene.render.resolution_y = 960, 640
    enough = threading.Event()
    begun = threading.Event()

    def escaped(_engine: Any) -> bool:
        begun.set()
        return enough.is_set()

    def other() -> None:
        begun.wait()
        for _ in range(50):
            time.sleep(0.001)
        enough.set()

    monkeypatch.setattr(engine.PENUMBRA_RE_engine, "_escaped", escaped)
    thread = threading.Thread(target=other)
    thread.start()
    bpy.ops.render.render()
    thread.join()
    assert enough.is_set()


class View:
    """A viewport without a window."""

    def __init__(self, export: bridge.SceneExport, x: float) -> None:
        self.export, self.x = export, x
        self.worker: Worker[Any] = Worker()
        self.pictures = Pictures()
        self.wanted = picture.Wanted(technique="shadow_map", settings={})

    def camera(self, size: tuple[int, int]) -> Any:
        made = self.export.scene.copy().camera
        matrix = made.world_from_camera
        matrix[0, 3] += self.x
        made.world_from_camera = matrix
        made.width_px, made.height_px = size
        return made

    def ask(self, key: Any, size: tuple[int, int]) -> None:
        own = replace(self.export, scene=self.export.scene.copy())
        self.worker.ask(self.pictures.question(key, own, self.camera, size, self.wanted, smaller=1))

    def answer(self, key: Any) -> Any:
        return wait_for(lambda: self.worker.shown if self.worker.shown and self.worker.shown.key == key else None)

    def alone(self, size: tuple[int, int]) -> Any:
        """The same picture from a renderer that has nothing else to do."""
        export = replace(self.export, scene=self.export.scene.copy())
        export.scene.camera = self.camera(size)
        made = picture.Painter(core.Renderer(), export, self.wanted, picture.Progress(show=False)).sample(0)
        return made.planes["Combined"]


def wait_for(what: Callable[[], Any]) -> Any:
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(0.002)
    raise AssertionError("waited in vain")


def exported() -> bridge.SceneExport:
    return bridge.read_scene(bpy.context.evaluated_depsgraph_get())


def test_four_viewports_and_a_render_at_once_each_show_their_own(addon: Kit) -> None:
    """A quad view, and F12 beside it."""
    furnished(addon)
    export = exported()
    views = [View(export, 0.4 * number) for number in range(4)]
    try:
        for round_ in range(5):
            for view in views:
                view.ask(round_, SIZE)
            assert bpy.ops.render.render() == {"FINISHED"}
            shown = [view.answer(round_).pixels for view in views]
        for view, pixels in zip(views, shown, strict=True):
            assert np.array_equal(pixels, view.alone(SIZE))
        assert all(not np.array_equal(a, b) for a, b in itertools.pairwise(shown))
    finally:
        for view in views:
            view.worker.close()


def test_sixty_sizes_of_a_viewport_do_not_grow_the_process(addon: Kit) -> None:
    furnished(addon)
    view = View(exported(), 0.0)

    def resident_mb() -> float:
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    try:
        sizes = []
        for number in range(60):
            size = (40 + number * 37 % 160, 24 + number * 53 % 120)
            view.ask(number, size)
            assert view.answer(number).size == size
            sizes.append(resident_mb())
        assert max(sizes[45:]) - max(sizes[:20]) < 50
    finally:
        view.worker.close()


def test_one_that_comes_and_goes_twenty_times_leaves_no_thread_and_no_memory(kit: Kit) -> None:
    furnished(kit)

    def resident_mb() -> float:
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    threads = threading.active_count()
    sizes = []
    for _ in range(20):
        penumbra.register()
        kit.scene.render.engine = "PENUMBRA"
        bpy.ops.render.render()
        kit.scene.render.engine = "BLENDER_WORKBENCH"
        penumbra.unregister()
        sizes.append(resident_mb())
    assert threading.active_count() == threads
    assert sizes[-1] - sizes[4] < 50


@pytest.mark.parametrize("act", ["render", "viewport", "examine"])
def test_blender_ends_by_itself_after(act: str) -> None:
    """A render engine that is still registered hangs 4.5 and crashes 4.2 at exit; ours takes itself back."""
    acts = {
        "render": "bpy.context.scene.render.resolution_percentage = 2; bpy.ops.render.render()",
        "examine": "bpy.ops.penumbra.examine()",
        "viewport": "\n".join(
            [
                "from penumbra.viewport.worker import Question, Worker",
                "worker = Worker()",
                "worker.ask(Question('a', lambda renderer, desk: desk.show(1)))",
                "import time",
                "while worker.shown is None and not worker.problem: time.sleep(0.01)",
            ]
        ),
    }
    script = (
        "import bpy, penumbra; penumbra.register(); bpy.context.scene.render.engine = 'PENUMBRA'\n"
        f"{acts[act]}\nprint('done', flush=True)"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert "done" in ran.stdout, ran.stderr
    assert ran.returncode == 0, ran.stderr


def test_the_command_line_renders_with_penumbra_whatever_engine_the_file_names(addon: Kit, tmp_path: Path) -> None:
    """A farm without the add-on falls back to EEVEE without a word; ours needs no engine of Blender's."""
    furnished(addon)
    pictures = []
    for engine in ("PENUMBRA", "BLENDER_WORKBENCH"):
        addon.scene.render.engine = engine
        blend, out = tmp_path / f"{engine}.blend", tmp_path / f"{engine}.png"
        bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True)
        words = ["render", str(blend), "--technique", "shadow_map", "--out", str(out)]
        folders = [str(Path(penumbra.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
        ran = subprocess.run(
            [sys.executable, "-m", "penumbra", *words], capture_output=True, text=True, timeout=120,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(folders)},
        )  # fmt: skip
        assert ran.returncode == 0, ran.stderr
        pictures.append(out.read_bytes())
    assert pictures[0] == pictures[1]
