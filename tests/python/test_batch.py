"""Batches for real, on a tiny animated scene: worker processes, kills, resumes, crashes, summaries."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from batch_kit import OPTIONS, PATIENCE_S, children, finished, gone, summary_of, wait_until
from checks import check_page

pytestmark = pytest.mark.usefixtures("working_machine")

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def words(moving: Path, tmp_path: Path) -> list[str]:
    """A batch of four frames."""
    return ["batch", str(moving), "--frames=1-4", "--out", str(tmp_path / "out"), *OPTIONS]


# --- a batch that goes well ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def batch(
    moving: Path, wall_blend: Path, environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[str], subprocess.CompletedProcess[str]]:
    """Two scenes, of which one has two frames, by two workers: (output, command line, process)."""
    out = tmp_path_factory.mktemp("batch") / "out"
    job = out.parent / "night.toml"
    job.write_text(
        f"""
size = "64x36"
techniques = ["shadow_map", "ray_traced"]
lights = ["Key"]
reference_error = 0.1
workers = 2
[[scenes]]
path = {str(moving)!r}
frames = "1,4"
[[scenes]]
path = {str(wall_blend)!r}
name = "Still Wall"
techniques = ["shadow_map"]
"""
    )
    words = ["batch", str(job), "--out", str(out)]
    result = subprocess.run(
        [sys.executable, "-m", "penumbra", *words], capture_output=True, text=True, env=environment, timeout=600
    )
    assert result.returncode == 0, result.stderr
    return out, words, result


Batch = tuple[Path, list[str], "subprocess.CompletedProcess[str]"]


def test_every_item_has_a_whole_report_of_its_own_and_nothing_else_lies_about(batch: Batch) -> None:
    out, _, result = batch
    assert finished(out) == ["moving/0001", "moving/0004", "still-wall/current"]
    assert sorted(path.name for path in out.iterdir()) == [
        "moving", "still-wall", "summary.csv", "summary.html", "summary.json",
    ]  # fmt: skip
    assert result.stdout.splitlines()[0] == "3 items: 0 done before, 3 to do (3 new)"
    assert result.stdout.splitlines()[-1] == f"summary: {out / 'summary.html'}"
    assert "Traceback" not in result.stderr and "Blender" not in result.stdout


def test_frames_differ_and_the_same_item_alone_has_the_same_error(batch: Batch, penumbra: Run, tmp_path: Path) -> None:
    out, _, _ = batch
    first, last = (json.loads((out / "moving" / name / "report.json").read_text()) for name in ("0001", "0004"))
    assert (first["scenes"][0]["frame"], last["scenes"][0]["frame"]) == (1, 4)

    def error(report: dict[str, Any]) -> float:
        return float(report["scenes"][0]["lights"][0]["records"][0]["error"]["area"]["rmse"])

    assert error(first) != error(last)
    words = first["environment"]["command"].split()[1:]
    alone = penumbra(*(word.strip("'") for word in words), "--out", tmp_path / "alone")
    assert alone.returncode == 0, alone.stderr
    assert error(json.loads((tmp_path / "alone" / "report.json").read_text())) == error(first)


def test_the_summary_has_the_worst_shot_first_and_every_technique(batch: Batch) -> None:
    out, _, _ = batch
    summary = summary_of(out)
    worst = [shot["worst"]["error"] for shot in summary["shots"]]
    assert worst == sorted(worst, reverse=True)
    assert summary["counts"] == {"items": 3, "done": 3, "kept": 0, "failed": 0, "retried": 0}
    counts = {technique["id"]: technique["error"]["count"] for technique in summary["techniques"]}
    assert counts == {"shadow_map": 3, "ray_traced": 2}
    for technique in summary["techniques"]:
        for spread in (technique["error"], technique["time_ms"]):
            assert spread["low"] <= spread["p10"] <= spread["median"] <= spread["p90"] <= spread["high"]
    rows = list(csv.DictReader((out / "summary.csv").open(newline="")))
    assert len(rows) == 5
    assert float(rows[0]["penumbra_rmse"]) == worst[0]


def test_the_summary_opens_offline_and_its_links_lead_to_reports(batch: Batch) -> None:
    out, _, _ = batch
    check_page(out / "summary.html")
    page = (out / "summary.html").read_text()
    for shot in summary_of(out)["shots"]:
        assert f'href="{shot["page"]}"' in page
        assert (out / shot["page"]).is_file()
    assert page.count("<svg viewBox") == 1 + 2  # the plot and its keys; no course of two frames


def test_a_browser_shows_the_summary(batch: Batch, chromium: str, tmp_path: Path) -> None:
    shot = tmp_path / "shot.png"
    subprocess.run(
        [chromium, "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
         "--window-size=1280,1000", f"--screenshot={shot}", (batch[0] / "summary.html").as_uri()],
        capture_output=True, timeout=120,
    )  # fmt: skip
    assert shot.stat().st_size > 30_000


def test_a_second_run_does_nothing_and_says_so(batch: Batch, penumbra: Run) -> None:
    out, words, _ = batch
    times = {path: path.stat().st_mtime_ns for path in out.glob("*/*/*")}
    result = penumbra(*words)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[0] == "3 items: all done before"
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/*/*")} == times
    assert summary_of(out)["counts"] == {"items": 3, "done": 0, "kept": 3, "failed": 0, "retried": 0}


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--warn-rmse=0.9", "--fail-rmse=0.95"], 0),
        (["--warn-rmse=0.01", "--fail-rmse=0.95"], 3),
        (["--warn-rmse=0.01", "--fail-rmse=0.02"], 4),
    ],
)
def test_limits_over_all_items_set_the_exit_code(batch: Batch, penumbra: Run, options: list[str], code: int) -> None:
    result = penumbra(*batch[1], "--summary-only", *options)
    assert result.returncode == code, result.stderr
    told = [line for line in result.stderr.splitlines() if line.startswith("penumbra: ")]
    assert len(told) == (1 if code else 0)
    verdicts = {shot["verdict"] for shot in summary_of(batch[0])["shots"]}
    assert verdicts == {{0: "ok", 3: "warn", 4: "fail"}[code]}


def test_a_dry_run_says_what_there_is_to_do_and_does_nothing(batch: Batch, penumbra: Run, tmp_path: Path) -> None:
    result = penumbra(*batch[1], "--dry-run", "--size=66x36")
    assert result.returncode == 0
    assert result.stdout.splitlines()[0] == "3 items: 0 done before, 3 to do (3 other options)"
    assert [line.split(maxsplit=1)[1] for line in result.stdout.splitlines()[1:]] == ["other options"] * 3
    assert penumbra("batch", batch[1][1], "--out", tmp_path / "new", "--dry-run").returncode == 0
    assert not (tmp_path / "new").exists()


# --- kills, crashes, interrupts --------------------------------------------------------------------------------------


def test_a_batch_whose_parent_is_killed_goes_on_where_it_was(
    started: Callable[..., subprocess.Popen[str]], penumbra: Run, words: list[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    process = started(words)
    wait_until(lambda: list(out.glob("*/*/item.json")), "a first item")
    workers = children(process.pid)
    process.kill()
    process.communicate()
    wait_until(lambda: all(gone(worker) for worker in workers), "the end of the orphaned worker")
    before = finished(out)
    assert 1 <= len(before) <= 4
    times = {name: (out / name / "item.json").stat().st_mtime_ns for name in before}
    result = penumbra(*words)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith(f"4 items: {len(before)} done before" if len(before) < 4 else "4 items: all")
    assert finished(out) == [f"moving/{frame:04d}" for frame in range(1, 5)]
    assert {name: (out / name / "item.json").stat().st_mtime_ns for name in before} == times
    assert not (out / ".penumbra").exists()


def test_an_item_whose_worker_is_killed_is_done_by_another(
    started: Callable[..., subprocess.Popen[str]], words: list[str], tmp_path: Path
) -> None:
    process = started([word.replace("1-4", "1-2") for word in words])
    out = tmp_path / "out"
    wait_until(lambda: list((out / ".penumbra" / "work").glob("*")), "a worker at work")
    (worker,) = children(process.pid)
    os.kill(worker, signal.SIGKILL)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, errors
    assert "is done at the second attempt" in errors
    assert finished(out) == ["moving/0001", "moving/0002"]
    assert summary_of(out)["counts"]["retried"] == 1


def test_an_item_that_crashes_twice_is_reported_with_its_last_words_and_the_others_go_on(
    penumbra: Run, words: list[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words[2] = "--frames=1-3"
    result = penumbra(*words, PENUMBRA_TEST_CRASH="moving/0002")
    assert result.returncode == 1
    told = [line for line in result.stderr.splitlines() if line.startswith("penumbra: ")]
    assert told == ["penumbra: moving/0002: its worker process died of SIGSEGV, twice"]
    assert finished(out) == ["moving/0001", "moving/0003"]
    (failure,) = summary_of(out)["failures"]
    assert any("PENUMBRA_TEST_CRASH" in line for line in failure["lines"])
    assert any("_crash_if_asked" in line for line in failure["lines"])
    page = (out / "summary.html").read_text()
    assert page.index("died of SIGSEGV") < page.index("<main")
    # Without the crash the next run does what is missing; with a crash that goes away, at the second attempt.
    once = tmp_path / "crash"
    once.touch()
    again = penumbra(*words, PENUMBRA_TEST_CRASH=f"moving/0002@{once}")
    assert again.returncode == 0, again.stderr
    assert again.stdout.startswith("3 items: 2 done before, 1 to do (1 new)")
    assert summary_of(out)["counts"] == {"items": 3, "done": 1, "kept": 2, "failed": 0, "retried": 1}
    assert not (out / ".penumbra").exists()


def test_an_interrupt_ends_all_and_keeps_what_is_finished(
    started: Callable[..., subprocess.Popen[str]], words: list[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    process = started([*words, "--workers=2"])
    wait_until(lambda: list(out.glob("*/*/item.json")), "a first item")
    workers = children(process.pid)
    assert workers
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert [line for line in errors.splitlines() if line.startswith("penumbra:")] == ["penumbra: interrupted"]
    assert "Traceback" not in errors
    assert all(gone(worker) for worker in workers)
    assert finished(out)
    assert not (out / ".penumbra").exists()


_LINK = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[-2])
with bpy.data.libraries.load(sys.argv[-1].replace("linking", "hero"), link=True) as (there, wanted):
    wanted.objects = ["Hero"]
bpy.context.scene.collection.objects.link(bpy.data.objects["Hero"])
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""
_HERO = """
import bpy, sys
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
mesh = bpy.data.meshes.new("Hero")
size = float(sys.argv[-2])
mesh.from_pydata([(0, 0, 1), (size, 0, 1), (0, size, 1)], [], [(0, 1, 2)])
bpy.context.scene.collection.objects.link(bpy.data.objects.new("Hero", mesh))
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""


def test_a_scene_is_done_anew_when_a_library_it_links_has_changed(
    penumbra: Run, wall_blend: Path, tmp_path: Path
) -> None:
    def blender(program: str, *words: object) -> None:
        subprocess.run([sys.executable, "-c", program, *map(str, words)], check=True, capture_output=True)

    scene, out = tmp_path / "linking.blend", tmp_path / "out"
    blender(_HERO, 1, tmp_path / "hero.blend")
    blender(_LINK, wall_blend, scene)
    words = ["batch", scene, "--out", out, "--render", "--technique=shadow_map", "--size=64x36", "--format=png"]
    assert penumbra(*words).returncode == 0
    picture = out / "linking" / "linking_current.png"
    before = picture.read_bytes()
    assert penumbra(*words, "--dry-run").stdout.startswith("1 item: all done before")
    blender(_HERO, 2, tmp_path / "hero.blend")
    again = penumbra(*words)
    assert again.stdout.startswith("1 item: 0 done before, 1 to do (1 hero.blend has changed)"), again.stdout
    assert picture.read_bytes() != before


def test_a_missing_camera_is_a_failure_of_its_items_alone(
    penumbra: Run, moving: Path, wall_blend: Path, tmp_path: Path
) -> None:
    job = tmp_path / "job.toml"
    job.write_text(
        f'size = "64x36"\nmode = "render"\ntechnique = "shadow_map"\nformat = "png"\n'
        f"[[scenes]]\npath = {str(moving)!r}\nframes = [1, 2]\n"
        f'[[scenes]]\npath = {str(wall_blend)!r}\ncameras = "Nobody"\n'
    )
    result = penumbra("batch", job, "--out", tmp_path / "out")
    assert result.returncode == 1
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("penumbra: ")]
    assert line.startswith("penumbra: wall/current-nobody: ") and "Nobody" in line
    out = tmp_path / "out"
    assert sorted(path.name for path in (out / "moving").iterdir()) == ["moving_0001.png", "moving_0002.png"]
    check_page(out / "summary.html")
    # Pictures are kept, made anew or left alone as Blender's options of these names have it.
    times = [path.stat().st_mtime_ns for path in sorted(out.glob("moving/*"))]
    changed = ["batch", moving, "--frames=1-2", "--out", out, "--render", "--technique=shadow_map", "--format=png"]
    assert penumbra(*changed, "--size=66x36", "--keep-existing").stdout.startswith("2 items: all done before")
    assert [path.stat().st_mtime_ns for path in sorted(out.glob("moving/*"))] == times
    overwritten = penumbra(*changed, "--size=64x36", "--overwrite")
    assert overwritten.stdout.startswith("2 items: 0 done before, 2 to do (2 to be overwritten)")
    assert all(a != b.stat().st_mtime_ns for a, b in zip(times, sorted(out.glob("moving/*")), strict=True))
