"""The comparison in a real Blender: run by operators, kept in the file, shown, reported, cancelled, switched off."""

from __future__ import annotations

import gc
import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import penumbra
import pytest
from blender_kit import Kit

FAST = ("shadow_map", "ray_traced")


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PENUMBRA_CACHE", str(tmp_path_factory.mktemp("cache")))


@pytest.fixture
def scene(addon: Kit) -> Kit:
    """A plate over a floor under a square light; two fast techniques are chosen."""
    addon.plate_over_floor()
    addon.scene.penumbra.reference_error = 0.05
    kept = addon.scene.penumbra_comparison
    kept.scale, kept.timing_seconds = 100, 0.05
    choose(addon, *FAST)
    bpy.context.view_layer.update()
    return addon


@pytest.fixture
def threaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As with a window: the operator comes back at once."""
    from penumbra.comparison import operators, running

    monkeypatch.setattr(operators, "force_thread", True)
    yield
    running.stop()


def choose(kit: Kit, *techniques: str) -> None:
    from penumbra import catalogue

    for info in catalogue.techniques():
        setattr(kit.scene.penumbra_comparison.techniques, info["id"], info["id"] in techniques)


def wait(seconds: float = 60) -> None:
    """Until the comparison in the background is over and collected."""
    from penumbra.comparison import operators

    end = time.monotonic() + seconds
    while operators.collect():
        assert time.monotonic() < end, "the comparison does not end"
        time.sleep(0.02)


@pytest.fixture
def choosy(monkeypatch: pytest.MonkeyPatch) -> str:
    """A core whose percentage-closer filtering does not serve the light; @returns why"""
    import penumbra_core as core
    from penumbra import native

    reason = "a light of this shape is not served"

    class Renderer:
        def __init__(self, device: str, **options: Any) -> None:
            self._renderer = core.Renderer(device, **options)

        def __getattr__(self, name: str) -> Any:
            return getattr(self._renderer, name)

        def supports(self, light: int, technique: str) -> str:
            return reason if technique == "pcf" else str(self._renderer.supports(light, technique))

    changed = SimpleNamespace(**{name: getattr(core, name) for name in dir(core)})
    changed.Renderer = Renderer
    native.fingerprint()
    monkeypatch.setattr(native, "load", lambda: changed)
    return reason


def threads() -> list[str]:
    return [thread.name for thread in threading.enumerate() if thread.name == "Penumbra comparison"]


def test_the_table_holds_what_the_comparer_finds(scene: Kit) -> None:
    import penumbra_core as core
    from penumbra import compare, progress, properties
    from penumbra.comparison import results
    from penumbra.panel import comparison as panel

    scene.scene.penumbra.settings.shadow_map.map_size = 512
    assert bpy.ops.penumbra.compare() == {"FINISHED"}
    kept = scene.scene.penumbra_comparison
    assert [row.technique for row in kept.rows] == list(FAST)
    assert all(row.status == "ok" and row.time_ms > 0 and row.light == "Key" for row in kept.rows)
    assert kept.heading == "Camera, 96 x 64, frame 1"
    assert panel.changed_settings(results.record_of(kept, kept.rows[0])) == {"map_size": 512}
    assert panel.changed_settings(results.record_of(kept, kept.rows[1])) == {}

    options = compare.Options(
        techniques=FAST,
        settings={name: properties.settings_of(scene.scene, name) for name in FAST},
        reference_error=scene.scene.penumbra.reference_error,
        timing_seconds=0.05,
        use_cache=False,
    )
    told = progress.Progress(show=False)
    alone = compare.Comparer(core, core.Renderer(), options, told).compare(scene.read(), "x.blend")
    for row, record in zip(kept.rows, alone.lights[0].records, strict=True):
        assert row.error == pytest.approx(record.headline, rel=1e-5)
        assert results.record_of(kept, row).area == record.area
        assert json.loads(row.settings) == record.settings
        assert results.record_of(kept, row).plan[0].step == record.plan[0].step


def test_what_of_the_scene_was_left_out_is_noted(scene: Kit) -> None:
    from penumbra.comparison import results

    scene.object("Dust", bpy.data.volumes.new("Dust"))
    choose(scene, "shadow_map")
    bpy.ops.penumbra.compare()
    (note,) = results.notes(scene.scene.penumbra_comparison)
    assert "Dust" in note


def test_twelve_comparisons_do_not_grow_the_process(scene: Kit) -> None:
    choose(scene, "shadow_map", "ray_traced")

    def resident_mb() -> float:
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

    sizes = []
    for _ in range(12):
        bpy.ops.penumbra.compare()
        bpy.ops.penumbra.show_result(row=0)
        sizes.append(resident_mb())
    assert sizes[-1] - sizes[3] < 50


def test_it_sorts_by_error_by_time_and_by_name_and_rows_without_figures_stand_last(scene: Kit, choosy: str) -> None:
    from penumbra.panel import comparison as panel

    choose(scene, "shadow_map", "pcf", "light_samples", "ray_traced")
    scene.scene.penumbra.settings.light_samples.samples = 4
    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    # Such figures that all three orders differ.
    for technique, error, time_ms in (("shadow_map", 0.3, 2.0), ("light_samples", 0.2, 3.0), ("ray_traced", 0.4, 1.0)):
        row = next(row for row in kept.rows if row.technique == technique)
        row.error, row.time_ms = error, time_ms

    def listed() -> list[str]:
        shown, places = panel.arranged(kept)
        assert all(shown) and sorted(places) == list(range(4))
        return [kept.rows[places.index(place)].technique for place in range(4)]

    assert listed() == ["light_samples", "shadow_map", "ray_traced", "pcf"]
    bpy.ops.penumbra.sort_results(by="ERROR")
    assert listed() == ["ray_traced", "shadow_map", "light_samples", "pcf"], "turned, the last stays last"
    bpy.ops.penumbra.sort_results(by="TIME")
    assert listed() == ["ray_traced", "shadow_map", "light_samples", "pcf"]
    bpy.ops.penumbra.sort_results(by="NAME")
    # Averaged shadow maps, Hard shadow map, Percentage-closer filtering, Ray tracing
    assert listed() == ["light_samples", "shadow_map", "pcf", "ray_traced"]
    shown, _ = panel.arranged(kept, "RAY")
    assert [kept.rows[i].technique for i, flag in enumerate(shown) if flag] == ["ray_traced"]


def test_a_row_that_is_not_served_says_why(scene: Kit, choosy: str) -> None:
    from penumbra.comparison import results

    choose(scene, "pcf", "shadow_map")
    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    row = next(row for row in kept.rows if row.technique == "pcf")
    assert (row.status, row.reason, row.error, row.time_ms) == ("unsupported", choosy, -1, -1)
    assert results.record_of(kept, row).reason == choosy
    assert kept.rows[kept.active_row].technique == "shadow_map", "the best is active"
    assert bpy.ops.penumbra.show_result(row=list(kept.rows).index(row)) == {"CANCELLED"}


def test_results_survive_save_and_reload(scene: Kit, tmp_path: Path) -> None:
    from penumbra.comparison import pictures, results

    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    before = [(row.name, row.error, row.time_ms, row.thumbnail) for row in kept.rows]
    plan = results.record_of(kept, kept.rows[0]).plan
    sentences = results.sentences(kept)
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not bpy.context.scene.penumbra_comparison.rows
    bpy.ops.wm.open_mainfile(filepath=path)
    kept = bpy.context.scene.penumbra_comparison
    assert [(row.name, row.error, row.time_ms, row.thumbnail) for row in kept.rows] == before
    assert results.record_of(kept, kept.rows[0]).plan == plan
    assert results.sentences(kept) == sentences
    assert len(results.plot_of(kept).curves) == 2
    thumbnail = pictures.read_thumbnail(kept.rows[0].thumbnail)
    assert thumbnail is not None and thumbnail.visibility.shape == (64, 96)
    assert bpy.ops.penumbra.show_result(row=0) == {"FINISHED"}, "the cache still has the pictures"


def test_results_take_little_room_in_the_file(scene: Kit, tmp_path: Path) -> None:
    bare, full = tmp_path / "bare.blend", tmp_path / "full.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(bare), copy=True)
    bpy.ops.penumbra.compare()
    bpy.ops.wm.save_as_mainfile(filepath=str(full), copy=True)
    assert full.stat().st_size - bare.stat().st_size < 40_000


def test_without_the_cache_the_figures_stay_and_the_pictures_are_missed_in_words(scene: Kit) -> None:
    import shutil

    from penumbra import cache
    from penumbra.comparison import show

    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    show.forget()
    shutil.rmtree(cache.folder())
    assert kept.rows[0].error > 0 and kept.rows[0].thumbnail
    assert bpy.ops.penumbra.show_result(row=0) == {"CANCELLED"}
    with pytest.raises(RuntimeError, match="not in this machine's cache; compare again"):
        bpy.ops.penumbra.open_report()


def test_a_shown_result_is_a_float_image_of_its_file_and_packed_only_when_asked(scene: Kit) -> None:
    from penumbra.comparison import results

    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    pixels = results.pictures_of(kept)
    reference, mask = pixels.reference(0)
    for what, expected in (("VISIBILITY", pixels.visibility(0, 0)), ("REFERENCE", reference)):
        assert bpy.ops.penumbra.show_result(row=0, what=what) == {"FINISHED"}
        image = next(image for image in bpy.data.images if image.get("penumbra") == what)
        values = np.empty(96 * 64 * 4, np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(64, 96, 4)
        assert np.allclose(values[..., 0], expected, atol=1e-6)
        assert np.array_equal(values[..., 3] != 0, mask != 0)
        assert image.is_float and not image.is_dirty and image.packed_file is None
    for what in ("ERROR", "SHADED"):
        assert bpy.ops.penumbra.show_result(row=1, what=what) == {"FINISHED"}
    assert len(bpy.data.images) == 4
    bpy.ops.penumbra.show_result(row=1)
    assert len(bpy.data.images) == 4, "one image for each kind"
    assert kept.active_row == 1
    bpy.ops.penumbra.pack_result()
    assert all(image.packed_file is not None for image in bpy.data.images)


def test_the_cheapest_within_the_error_is_what_the_scene_then_renders_with(scene: Kit) -> None:
    scene.scene.penumbra.settings.ray_traced.rays = 16
    bpy.ops.penumbra.compare()
    scene.scene.penumbra.settings.ray_traced.rays = 99
    kept = scene.scene.penumbra_comparison
    hard, traced = kept.rows
    hard.error, hard.time_ms, traced.error, traced.time_ms = 0.3, 1.0, 0.05, 5.0
    kept.target = 0.1
    assert bpy.ops.penumbra.use_cheapest() == {"FINISHED"}
    assert scene.scene.penumbra.technique == "ray_traced"
    assert scene.scene.penumbra.settings.ray_traced.rays == 16, "with the settings that were measured"
    kept.target = 0.5
    assert bpy.ops.penumbra.use_cheapest() == {"FINISHED"}
    assert scene.scene.penumbra.technique == "shadow_map"
    kept.target = 0.01
    assert bpy.ops.penumbra.use_cheapest() == {"CANCELLED"}
    assert scene.scene.penumbra.technique == "shadow_map"


def row(name: str, light: str, error: float, time_ms: float, status: str = "ok") -> Any:
    return SimpleNamespace(
        name=name, technique=name, light=light, settings="{}", status=status, error=error, time_ms=time_ms,
        is_sweep_step=False,
    )  # fmt: skip


def test_the_cheapest_must_be_within_the_error_at_every_light_and_pays_for_all() -> None:
    from penumbra.comparison import table

    rows = [
        row("fast", "A", 0.01, 1), row("slow", "A", 0.01, 5), row("mid", "A", 0.01, 3),
        row("fast", "B", 0.2, 1), row("slow", "B", 0.01, 5), row("mid", "B", 0.02, 9),
    ]  # fmt: skip
    assert table.cheapest(rows, 0.1) == 1
    assert table.cheapest(rows, 0.5) == 0
    assert table.cheapest(rows, 0.001) is None
    rows[4].status = "unsupported"
    assert table.cheapest(rows, 0.1) == 2


def test_the_report_is_written_again_from_the_file_and_the_cache(scene: Kit, tmp_path: Path) -> None:
    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    for _ in range(2):
        assert bpy.ops.penumbra.open_report(folder=str(tmp_path / "report")) == {"FINISHED"}
    written = {file.relative_to(tmp_path / "report").as_posix() for file in (tmp_path / "report").rglob("*.*")}
    assert {"report.html", "report.json", "results.csv", "pareto.png"} <= written
    assert "images/unsaved-scene/key/ray_traced_visibility.exr" in written
    document = json.loads((tmp_path / "report" / "report.json").read_text())
    (light,) = document["scenes"][0]["lights"]
    assert [r["technique"] for r in light["records"]] == list(FAST)
    assert light["records"][1]["error"]["area"]["penumbra_rmse"] == pytest.approx(kept.rows[1].error, rel=1e-5)
    assert document["environment"]["blender"] == bpy.app.version_string


def test_selected_lights_alone_are_compared_and_none_selected_is_said(scene: Kit) -> None:
    scene.light("POINT", name="Fill", energy=50, at=(2, -1, 3), shadow_soft_size=0.3)
    kept = scene.scene.penumbra_comparison
    bpy.ops.penumbra.compare()
    assert [light.name for light in kept.result_lights] == ["Fill", "Key"] or len(kept.result_lights) == 2
    assert len(kept.rows) == 4
    kept.lights = "SELECTED"
    for obj in bpy.data.objects:
        obj.select_set(obj.name == "Fill")
    bpy.ops.penumbra.compare()
    assert {row.light for row in kept.rows} == {"Fill"}
    bpy.data.objects["Fill"].select_set(False)
    with pytest.raises(RuntimeError, match="no light is selected"):
        bpy.ops.penumbra.compare()
    assert len(kept.rows) == 2, "the results from before stay"


def test_without_a_window_a_view_is_asked_for_in_vain_and_it_says_so(scene: Kit) -> None:
    scene.scene.penumbra_comparison.view = "VIEW"
    with pytest.raises(RuntimeError, match="no 3D viewport is open; compare with the scene's camera"):
        bpy.ops.penumbra.compare()


def test_nothing_chosen_is_nothing_to_compare(scene: Kit) -> None:
    choose(scene)
    with pytest.raises(RuntimeError, match="Choose a technique to compare"):
        bpy.ops.penumbra.compare()


def test_a_core_that_fails_is_a_sentence(scene: Kit, monkeypatch: pytest.MonkeyPatch) -> None:
    from penumbra import native
    from penumbra.comparison import running
    from penumbra.errors import UserError

    monkeypatch.setenv("PENUMBRA_DEVICE", "a device of nobody")
    with pytest.raises(RuntimeError, match="no device matches"):
        bpy.ops.penumbra.compare()
    assert "no device matches" in running.problem()
    monkeypatch.delenv("PENUMBRA_DEVICE")

    def gone() -> Any:
        raise UserError("the compiled module penumbra_core cannot be loaded in Python 3.99")

    with monkeypatch.context() as broken:
        broken.setattr(native, "load", gone)
        with pytest.raises(RuntimeError, match=r"cannot be loaded in Python 3\.99"):
            bpy.ops.penumbra.compare()
    assert bpy.ops.penumbra.compare() == {"FINISHED"}, "the next one works"
    assert running.problem() == ""


def test_in_the_background_the_operator_returns_at_once_and_the_results_arrive(scene: Kit, threaded: None) -> None:
    from penumbra.comparison import running

    kept = scene.scene.penumbra_comparison
    assert bpy.ops.penumbra.compare() == {"FINISHED"}
    assert not kept.rows
    assert running.current() is not None
    scene.scene.name = "Renamed meanwhile"
    bpy.data.objects["Plate"].location.x = 3.0
    wait()
    assert len(kept.rows) == 2
    assert running.current() is None and threads() == []


def slow(kit: Kit) -> None:
    """A comparison that would take minutes."""
    choose(kit, "ray_traced")
    kit.scene.penumbra.settings.ray_traced.rays = 65536
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = 960, 640


@pytest.mark.parametrize("after_s", [0.0, 0.3, 2.0])
def test_cancel_ends_it_soon_and_keeps_what_was_there(scene: Kit, threaded: None, after_s: float) -> None:
    from penumbra.comparison import running

    bpy.ops.penumbra.compare()
    wait()
    kept = scene.scene.penumbra_comparison
    before = [row.name for row in kept.rows]
    slow(scene)
    bpy.ops.penumbra.compare()
    time.sleep(after_s)
    assert bpy.ops.penumbra.compare_cancel() == {"FINISHED"}
    wait(20)
    assert running.problem() == "", "being cancelled is no failure"
    assert [row.name for row in kept.rows] == before
    assert threads() == []
    with pytest.raises(RuntimeError, match="No comparison is running"):
        bpy.ops.penumbra.compare_cancel()


def test_a_second_comparison_ends_the_first(scene: Kit, threaded: None) -> None:
    slow(scene)
    bpy.ops.penumbra.compare()
    choose(scene, "shadow_map")
    scene.scene.render.resolution_x, scene.scene.render.resolution_y = 48, 32
    bpy.ops.penumbra.compare()
    assert len(threads()) <= 1
    wait()
    assert [row.technique for row in scene.scene.penumbra_comparison.rows] == ["shadow_map"]


def test_opening_another_file_ends_it(scene: Kit, threaded: None) -> None:
    from penumbra.comparison import running

    slow(scene)
    bpy.ops.penumbra.compare()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert running.current() is None and threads() == []
    assert not bpy.context.scene.penumbra_comparison.rows


def test_a_scene_that_was_deleted_meanwhile_takes_its_results_with_it(scene: Kit, threaded: None) -> None:
    bpy.ops.penumbra.compare()
    other = bpy.data.scenes.new("Other")
    bpy.data.scenes.remove(scene.scene)
    wait()
    assert not other.penumbra_comparison.rows


def test_switching_off_while_it_runs_leaves_no_thread_and_no_trace(scene: Kit, threaded: None) -> None:
    slow(scene)
    bpy.ops.penumbra.compare()
    assert threads()
    penumbra.unregister()
    assert threads() == []
    assert not hasattr(bpy.types.Scene, "penumbra_comparison")
    assert not any("penumbra" in str(getattr(handler, "__module__", "")) for handler in bpy.app.handlers.load_pre)
    penumbra.register()


def test_blender_ends_by_itself_while_a_comparison_runs() -> None:
    script = (
        "import bpy, penumbra; penumbra.register();"
        "from penumbra.comparison import operators; operators.force_thread = True;"
        "s = bpy.context.scene; s.penumbra.settings.ray_traced.rays = 65536;"
        "print(bpy.ops.penumbra.compare())"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert "FINISHED" in ran.stdout
    assert ran.returncode == 0, ran.stderr


class Told:
    """A layout that takes everything and writes down the words and the icons."""

    def __init__(self, words: list[str] | None = None) -> None:
        object.__setattr__(self, "words", [] if words is None else words)

    def __setattr__(self, name: str, value: Any) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        def call(*given: Any, **named: Any) -> Any:
            if name == "prop":
                assert named.get("text") is not None or given[0].bl_rna.properties[given[1]].description
                assert given[1] in given[0].bl_rna.properties
            if name == "operator":
                space, operator = given[0].split(".")
                assert hasattr(getattr(bpy.ops, space), operator)
                self.words.append(str(named.get("text", "")))
                return SimpleNamespace()
            self.words.extend(str(named[what]) for what in ("text", "icon") if what in named)
            return Told(self.words)

        return call


def test_every_panel_draws_before_and_after_and_while_comparing(scene: Kit, threaded: None) -> None:
    from penumbra.comparison import results
    from penumbra.panel import comparison as panel

    region = SimpleNamespace(width=280)

    def drawn() -> str:
        words: list[str] = []
        context = SimpleNamespace(scene=scene.scene, region=region, preferences=bpy.context.preferences)
        for _, _, draw, _, _, needs_results in panel._PANELS:
            if not needs_results or scene.scene.penumbra_comparison.rows:
                draw(Told(words), context)
        return " ".join(words)

    scene.scene.penumbra_comparison.techniques.pcf_open = True
    assert "ending" not in drawn()
    bpy.ops.penumbra.compare()
    assert "%" in drawn()
    wait()
    after = drawn()
    # Which technique is the faster is the machine's to say: the sentences must be those of the results, whoever won.
    said = results.sentences(scene.scene.penumbra_comparison)
    assert len(said) >= 1
    for words in ("Camera, 96 x 64, frame 1", "Penumbra RMSE", "Dynamic frame"):
        assert words in after
    for sentence in said:
        assert set(sentence.split()) <= set(after.split())
    scene.scene.penumbra_comparison.key = "gone"
    assert "compare again" in drawn()


def test_table_and_plan_say_where_a_technique_leaves_its_field_of_use(scene: Kit) -> None:
    from penumbra.comparison import results
    from penumbra.panel import comparison as panel

    bpy.ops.penumbra.compare()
    kept = scene.scene.penumbra_comparison
    context = SimpleNamespace(
        scene=scene.scene, region=SimpleNamespace(width=2000), preferences=bpy.context.preferences
    )
    warning = "the light is 1 m wide and one point stands for it: no penumbra is drawn"
    for row, warnings in zip(kept.rows, ([warning], []), strict=True):
        assert results.record_of(kept, row).warnings == warnings
        assert row.outside == bool(warnings)
        kept.active_row = list(kept.rows).index(row)
        for draw in (panel.draw_results, panel.draw_plan):
            words: list[str] = []
            draw(Told(words), context)
            assert (f"{row.name}, outside its field of use: {warning}." in words) == bool(warnings)
        words = []
        panel.PENUMBRA_UL_results.draw_item(None, context, Told(words), kept, row, 0, kept, "active_row")
        assert ("ERROR" in words) == bool(warnings)


def test_the_plot_shows_a_mark_in_each_techniques_colour_and_is_drawn_anew() -> None:
    from penumbra.comparison import plot
    from penumbra.report import palette

    points = [plot.Curve(i, [plot.Point(10.0**i, 0.1 / 4**i, 10.0**i, 10.0**i)]) for i in range(3)]
    picture = plot.draw(plot.Plot(points))
    assert picture.shape == (plot.HEIGHT, plot.WIDTH, 4)
    places = []
    for i in range(3):
        code = bytes.fromhex(palette.colour(i).lstrip("#"))
        rows, columns = np.nonzero((picture[..., :3] == list(code)).all(axis=-1))
        assert len(rows) > 80
        places.append((columns.mean(), rows.mean()))
    assert places[0][0] < places[1][0] < places[2][0] and places[0][1] > places[1][1] > places[2][1]
    moved = plot.draw(plot.Plot(points, target=0.02))
    assert not np.array_equal(moved, picture)
    assert plot.draw(plot.Plot()).shape == picture.shape
