"""What the tests of batches share; its fixtures are in conftest.py."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from checks import check_files

OPTIONS = ("--size=64x36", "--techniques=shadow_map", "--lights=Key", "--reference-error=0.1")
PATIENCE_S = 60.0


def summary_of(folder: Path) -> dict[str, Any]:
    def refuse(word: str) -> None:
        raise AssertionError(f"summary.json holds {word}")

    document: dict[str, Any] = json.loads((folder / "summary.json").read_text(), parse_constant=refuse)
    return document


def children(pid: int) -> list[int]:
    found = []
    for folder in Path("/proc").iterdir():
        with contextlib.suppress(OSError, ValueError):
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == pid:
                found.append(int(folder.name))
    return found


def wait_until(happened: Callable[[], Any], what: str) -> Any:
    """A folder that goes while it is looked into has not happened yet."""
    end = time.monotonic() + PATIENCE_S
    while True:
        with contextlib.suppress(FileNotFoundError):
            found = happened()
            if found:
                return found
        assert time.monotonic() < end, f"never happened: {what}"
        time.sleep(0.01)


def gone(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return "\nState:\tZ" in Path(f"/proc/{pid}/status").read_text()
    return True


def finished(out: Path) -> list[str]:
    """Items that are there; every one of them is whole."""
    items = sorted(path.parent for path in out.glob("*/*/item.json"))
    for item in items:
        check_item(item)
    folders = [path for path in out.glob("*/*") if path.is_dir() and path.parent.name != ".penumbra"]
    assert sorted(folders) == items, "a folder without its item.json"
    return [str(item.relative_to(out)) for item in items]


def check_item(folder: Path) -> None:
    inside = json.loads((folder / "item.json").read_text())
    assert inside["item"] == str(folder.relative_to(folder.parents[1]))
    check_files(folder)
