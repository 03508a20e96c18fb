from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from penumbra import files


def fail_while_writing(target: Path) -> None:
    with files.whole_file(target) as writable:
        writable.write_bytes(b"new")
        raise ZeroDivisionError


def test_a_file_appears_whole_when_its_block_ends(tmp_path: Path) -> None:
    target = tmp_path / "report.json"
    with files.whole_file(target) as writable:
        writable.write_bytes(b"half")
        assert not target.exists()
    assert target.read_bytes() == b"half"
    assert os.listdir(tmp_path) == ["report.json"]


def test_an_exception_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    target = tmp_path / "report.json"
    files.write_bytes(target, b"old")
    with pytest.raises(ZeroDivisionError):
        fail_while_writing(target)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["report.json"]


def test_the_fallback_for_file_systems_without_nameless_files_is_whole_as_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "_open_nameless", lambda folder: None)
    target = tmp_path / "report.json"
    files.write_bytes(target, b"old")
    with pytest.raises(ZeroDivisionError):
        fail_while_writing(target)
    assert target.read_bytes() == b"old"
    files.write_bytes(target, b"new")
    assert target.read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["report.json"]


def test_permissions_are_those_of_an_ordinary_new_file(tmp_path: Path) -> None:
    ordinary, ours = tmp_path / "ordinary", tmp_path / "ours"
    ordinary.write_bytes(b"")
    files.write_bytes(ours, b"")
    assert ours.stat().st_mode == ordinary.stat().st_mode


def test_a_process_killed_while_writing_leaves_no_file_at_all(tmp_path: Path, environment: dict[str, str]) -> None:
    program = """
import sys, time
from pathlib import Path
from penumbra.files import whole_file
with whole_file(Path(sys.argv[1])) as writable, open(writable, "wb") as file:
    file.write(b"x" * 100000)
    file.flush()
    print("writing", flush=True)
    time.sleep(60)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path / "image.exr")], stdout=subprocess.PIPE, env=environment
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"writing\n"
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()
    time.sleep(0.05)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("place", ["file/inside", "file"])
def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    assert files.why_not_writable(tmp_path / place) == f"{tmp_path / 'file'} is a file, not a folder"


def test_asking_whether_a_folder_is_writable_makes_nothing(tmp_path: Path) -> None:
    assert files.why_not_writable(tmp_path / "a" / "b") == ""
    assert os.listdir(tmp_path) == []


def test_proc_is_not_writable_even_for_the_superuser() -> None:
    assert files.why_not_writable(Path("/proc/penumbra")) != ""
