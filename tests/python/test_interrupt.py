"""Ctrl-C ends a real run within a second, whatever it is doing, and leaves nothing half written."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

WITHIN_S = 1.0
TRIES = 3
_ESCAPES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")

# Evaluating this takes Blender minutes in one call, but hardly any memory.
_SLOW_SCENE = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[-2])
bpy.ops.mesh.primitive_grid_add(x_subdivisions=200, y_subdivisions=200)
for i in range(10):
    smooth = bpy.context.object.modifiers.new(f"Smooth {i}", "SMOOTH")
    smooth.iterations = 30000
    smooth.show_viewport = False
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1], compress=False)
"""


def allowed_s() -> float:
    """A second of a machine that is ours; where others run, our share of it comes later."""
    return WITHIN_S * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


class Run:
    """`penumbra` on a terminal of its own."""

    def __init__(self, arguments: list[str], environment: dict[str, str], folder: Path) -> None:
        self._terminal, other_end = pty.openpty()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "penumbra", *arguments],
            stdin=other_end,
            stdout=other_end,
            stderr=other_end,
            cwd=folder,
            env=environment | {"COLUMNS": "160", "TERM": "xterm"},
        )
        os.close(other_end)
        self._told = ""

    def told(self, wait_s: float = 0.0) -> str:
        with contextlib.suppress(OSError):  # what a terminal says whose other end is closed
            while select.select([self._terminal], [], [], wait_s)[0]:
                self._told += os.read(self._terminal, 1 << 16).decode("utf-8", "replace")
                wait_s = 0.0
        return self._told

    def wait_for(self, text: str, patience_s: float = 240.0) -> None:
        end = time.monotonic() + patience_s
        while text not in self.told(0.05):
            assert self._process.poll() is None and time.monotonic() < end, f"never said {text!r}: {self.last_words()}"

    def interrupt(self) -> float:
        """Seconds until the process was gone."""
        sent = time.monotonic()
        self._process.send_signal(signal.SIGINT)
        while self._process.poll() is None and time.monotonic() < sent + 60:
            self.told(0.01)
        took = time.monotonic() - sent
        assert self._process.poll() is not None, f"Ctrl-C was not heard: {self.last_words()}"
        return took

    @property
    def code(self) -> int | None:
        return self._process.poll()

    def last_words(self) -> str:
        lines = _ESCAPES.sub("", self.told(0.1)).replace("\r", "\n").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def cursor_is_shown(self) -> bool:
        told = self.told(0.1)
        return told.rfind("\x1b[?25h") >= told.rfind("\x1b[?25l")

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        os.close(self._terminal)


def interrupted(
    phase: str, delay_s: float, arguments: list[object], environment: dict[str, str], folder: Path
) -> tuple[int | None, str]:
    """Exit code and last words of the first try that was quick enough."""
    out = folder / "out"
    took = []
    for _ in range(TRIES):
        run = Run(["compare", *map(str, arguments), "--out", str(out)], environment, folder)
        try:
            if phase:
                run.wait_for(phase)
            time.sleep(delay_s)
            assert run.code is None, f"ended by itself: {run.last_words()}"
            allowed = allowed_s()
            took.append(run.interrupt())
            assert run.cursor_is_shown()
            assert whole(out)
            if took[-1] <= allowed:
                return run.code, run.last_words()
        finally:
            run.close()
    pytest.fail(f"{phase or 'start'}: ended after {', '.join(f'{seconds:.2f} s' for seconds in took)}")


def whole(out: Path) -> bool:
    """No report without its files, and no file under a temporary name."""
    files = [path for path in out.rglob("*") if path.is_file()]
    for path in files:
        assert path.suffix in (".html", ".json", ".csv", ".exr", ".png", ".svg"), path
    if (out / "report.json").exists():
        json.loads((out / "report.json").read_text())
    assert not (out / "report.html").exists()
    return True


@pytest.fixture
def run_environment(environment: dict[str, str]) -> dict[str, str]:
    return environment | {"PENUMBRA_CACHE": os.environ["PENUMBRA_CACHE"]}


@pytest.mark.usefixtures("working_machine")
def test_a_reference_of_hours_is_interrupted(wall_blend: Path, tmp_path: Path, run_environment: dict[str, str]) -> None:
    arguments = [wall_blend, "--size", "960x540", "--reference-error", "0.00002"]
    code, words = interrupted("reference", 0.5, arguments, run_environment, tmp_path)
    assert (code, words) == (130, "penumbra: interrupted")


@pytest.mark.usefixtures("working_machine")
def test_the_timing_of_all_techniques_is_interrupted(
    wall_blend: Path, tmp_path: Path, run_environment: dict[str, str]
) -> None:
    arguments = [wall_blend, "--reference-error", "0.5", "--lights", "Key"]
    code, words = interrupted("timing", 0.5, arguments, run_environment, tmp_path)
    assert (code, words) == (130, "penumbra: interrupted")


@pytest.mark.usefixtures("working_machine")
def test_reading_a_scene_that_blender_evaluates_for_minutes_is_interrupted(
    wall_blend: Path, tmp_path: Path, run_environment: dict[str, str]
) -> None:
    slow = tmp_path / "slow.blend"
    made = subprocess.run(
        [sys.executable, "-c", _SLOW_SCENE, str(wall_blend), str(slow)], capture_output=True, text=True
    )
    assert slow.is_file(), made.stderr
    code, _ = interrupted("slow: reading", 4.0, [slow], run_environment, tmp_path)
    assert code in (130, -signal.SIGINT)  # in the loop of an evaluation nothing but the signal itself ends it


@pytest.mark.usefixtures("working_machine")
@pytest.mark.parametrize("delay_s", [0.0, 0.2, 0.4, 0.8])
def test_no_interrupt_is_lost_while_blender_is_loaded(
    delay_s: float, wall_blend: Path, tmp_path: Path, run_environment: dict[str, str]
) -> None:
    arguments = [wall_blend, "--size", "960x540", "--reference-error", "0.00002"]
    code, _ = interrupted("reading", delay_s, arguments, run_environment, tmp_path)
    assert code in (130, -signal.SIGINT)
