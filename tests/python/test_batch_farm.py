"""Batches on engines of others: a Dask cluster that loses a worker, and an Open Job Description run by openjd."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from batch_kit import OPTIONS, children, finished, gone, summary_of, wait_until
from must_run import skip
from penumbra.batch import openjd
from penumbra.batch.jobs import Job, Shot
from penumbra.compare import Options
from penumbra.errors import UserError

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def cluster(environment: dict[str, str], tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """A scheduler and two workers with one thread each, as a farm starts them: (address, worker processes)."""
    if importlib.util.find_spec("distributed") is None:
        skip("Dask is not installed")
    variables = environment | {
        "PENUMBRA_CACHE": os.environ["PENUMBRA_CACHE"],
        "DASK_DISTRIBUTED__WORKER__DAEMON": "False",
        "DASK_DISTRIBUTED__ADMIN__TICK__LIMIT": "1h",
    }

    def start(*words: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=variables, cwd=tmp_path,
        )  # fmt: skip

    scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    workers: list[subprocess.Popen[str]] = []
    try:
        assert scheduler.stderr is not None
        told = ""
        while not (found := re.search(r"Scheduler at:\s+(tcp://\S+)", told)):
            line = scheduler.stderr.readline()
            assert line, told
            told += line
        for stream in (scheduler.stderr,):
            threading.Thread(target=stream.read, daemon=True).start()
        for _ in range(2):
            workers.append(start("worker", found[1], "--nthreads", "1", "--no-nanny", "--no-dashboard"))
            threading.Thread(target=workers[-1].stderr.read, daemon=True).start()  # type: ignore[union-attr]
        yield found[1], workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


@pytest.mark.usefixtures("working_machine")
def test_a_dask_worker_that_is_killed_loses_no_item_and_counts_as_no_crash(
    cluster: tuple[str, list[subprocess.Popen[str]]], started: Callable[..., subprocess.Popen[str]], moving: Path,
    tmp_path: Path,
) -> None:  # fmt: skip
    address, workers = cluster
    out = tmp_path / "out"
    process = started(["batch", str(moving), "--frames=1-4", "--out", str(out), "--dask", address, *OPTIONS])
    # Both have an item when one of them dies.
    wait_until(lambda: len(list((out / ".penumbra" / "work").glob("*"))) == 2, "two workers at work")
    (orphan,) = children(workers[0].pid)
    os.kill(workers[0].pid, signal.SIGKILL)
    _, errors = process.communicate(timeout=240)
    assert process.returncode == 0, errors
    wait_until(lambda: gone(orphan), "the end of the orphaned child")
    assert finished(out) == [f"moving/{frame:04d}" for frame in range(1, 5)]
    assert summary_of(out)["counts"] == {"items": 4, "done": 4, "kept": 0, "failed": 0, "retried": 0}


@pytest.mark.usefixtures("core")
def test_without_a_scheduler_the_sentence_names_the_address(penumbra: Run, tmp_path: Path) -> None:
    if importlib.util.find_spec("distributed") is None:
        skip("Dask is not installed")
    (tmp_path / "a.blend").write_text("no scene")
    address = "tcp://127.0.0.1:9"
    result = penumbra("batch", tmp_path / "a.blend", "--out", tmp_path / "out", "--dask", address)
    assert result.returncode == 2
    assert f"no Dask scheduler answers at {address}" in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("core")
def test_without_dask_the_sentence_says_how_to_get_it(penumbra: Run, tmp_path: Path) -> None:
    (tmp_path / "block" / "distributed").mkdir(parents=True)
    (tmp_path / "block" / "distributed" / "__init__.py").write_text("raise ImportError('no')")
    (tmp_path / "a.blend").write_text("no scene")
    path = os.pathsep.join([str(tmp_path / "block"), *sys.path])
    words = ["batch", tmp_path / "a.blend", "--out", tmp_path / "out", "--dask", "tcp://127.0.0.1:9"]
    result = penumbra(*words, PYTHONPATH=path)
    assert result.returncode == 2
    assert "pip install 'penumbra[dask]'" in result.stderr


# --- Open Job Description --------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def openjd_program() -> str:
    found = shutil.which("openjd", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
    if found is None:
        skip("the openjd command line is not installed")
    return found


def two_shots(**changes: Any) -> Job:
    options = Options(techniques=("shadow_map", "pcf"), settings={"pcf": {"kernel": 5}}, lights=("Key 'left'",))
    shots = (
        Shot("first", Path("first.blend"), (1, 2, 3, 7), ("Left Eye", "Right"), (64, 36), options, fail_rmse=0.5),
        Shot("second", Path("second.blend")),
    )
    return Job(shots, Path("out"), **changes)


@pytest.mark.parametrize("job", [two_shots(), two_shots(mode="render", technique="pcf", format="png")])
@pytest.mark.parametrize("ending", ["json", "yaml"])
def test_the_description_is_valid(job: Job, ending: str, openjd_program: str, tmp_path: Path) -> None:
    path = tmp_path / f"job.{ending}"
    openjd.write(job, path)
    result = subprocess.run([openjd_program, "check", str(path)], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_every_frame_and_camera_is_a_task_and_the_summary_waits_for_all() -> None:
    document = openjd.template(two_shots(), Path())
    first, second, last = document["steps"]
    frames, cameras = first["parameterSpace"]["taskParameterDefinitions"]
    assert (frames["range"], cameras["range"]) == ("1-3,7", ["Left Eye", "Right"])
    assert "parameterSpace" not in second
    assert [entry["dependsOn"] for entry in last["dependencies"]] == ["first", "second"]


@pytest.mark.parametrize(
    ("shot", "says"),
    [
        (Shot("a", Path("a.blend"), (1,), ("{{Job.Name}}",)), "{{"),
        (Shot("a", Path("a.blend"), (1,), ("Left", "left")), "differ only in"),
        (Shot("Summary", Path("a.blend"), (1,)), "is called Summary"),
    ],
)
def test_what_cannot_be_written_down_is_one_sentence(shot: Shot, says: str) -> None:
    with pytest.raises(UserError, match=re.escape(says)):
        openjd.template(Job((shot,), Path("out")), Path())


@pytest.mark.usefixtures("working_machine")
def test_openjd_runs_tasks_and_the_summary_which_fails_for_what_is_missing_and_what_is_too_wrong(
    openjd_program: str, penumbra: Run, moving: Path, environment: dict[str, str], tmp_path: Path
) -> None:
    out, path, program = tmp_path / "out", tmp_path / "job.yaml", tmp_path / "penumbra"
    result = penumbra("batch", moving, "--frames=2-3", "--out", out, *OPTIONS, "--openjd", path)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines() == [str(path), f"give when submitting: Scene1={moving}"]
    assert not out.exists()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m penumbra "$@"\n')
    program.chmod(0o755)

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [openjd_program, "run", str(path), "-p", f"Penumbra={program}", "-p", f"Scene1={moving}", *words],
            capture_output=True, text=True, env=environment | {"PENUMBRA_CACHE": os.environ["PENUMBRA_CACHE"]},
            timeout=300,
        )  # fmt: skip

    task = run("--step", "moving", "--task-param", "Frame=3")
    assert task.returncode == 0, task.stdout + task.stderr
    assert finished(out) == ["moving/0003"]
    assert not (out / "summary.html").exists()
    # The other task has not run: the summary shows what there is, and fails.
    last = run("--step", "Summary")
    assert last.returncode != 0
    summary = summary_of(out)
    assert [shot["id"] for shot in summary["shots"]] == ["moving/0003"]
    assert [failure["item"] for failure in summary["failures"]] == ["moving/0002"]
    # With all of its tasks the job ends well; with a limit that is passed it does not.
    task = run("--step", "moving", "--task-param", "Frame=2")
    assert task.returncode == 0, task.stdout + task.stderr
    last = run("--step", "Summary")
    assert last.returncode == 0, last.stdout + last.stderr
    assert finished(out) == ["moving/0002", "moving/0003"]
    assert summary_of(out)["failures"] == []
    gated = penumbra("batch", moving, "--frames=2-3", "--out", out, *OPTIONS, "--fail-rmse=0.0001", "--openjd", path)
    assert gated.returncode == 0, gated.stderr
    last = run("--step", "Summary")
    assert last.returncode != 0
    assert {shot["verdict"] for shot in summary_of(out)["shots"]} == {"fail"}
