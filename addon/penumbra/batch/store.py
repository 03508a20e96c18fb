"""The output folder: where results lie, what they were made from, and how they get there whole.

    OUT/<scene>/<frame>[-<camera>]/     one comparison: report.html ... and item.json
    OUT/<scene>/[<camera>/]<scene>_0001.exr   one picture of `--render`
    OUT/.penumbra/work/                 what is being made; nobody else looks here
    OUT/.penumbra/pictures/             item.json of each picture
    OUT/.penumbra/failed/               what went wrong with an item, until it is done

A result is made in a work folder and moved to its place, so that it is there whole or not at all, however its process
ends. item.json says what it was made from: options, build of the core, and the content of every file that was read.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import re
import secrets
import shutil
import socket
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import __version__, native
from ..files import write_bytes
from .jobs import Item

SCHEMA = 1
ITEM_FILE = "item.json"
HASHED_BYTES = 256 << 20  # larger files are known by size and time alone

Document = dict[str, Any]


class Facts:
    """Size, time and content of files; each is read once."""

    def __init__(self) -> None:
        self._hashes: dict[tuple[str, int, int], str] = {}

    def of(self, path: Path) -> Document:
        """@raises OSError if the file cannot be read"""
        state = path.stat()
        facts = {"path": str(path), "size": state.st_size, "mtime_ns": state.st_mtime_ns, "sha256": ""}
        if state.st_size <= HASHED_BYTES:
            key = (str(path), state.st_size, state.st_mtime_ns)
            if key not in self._hashes:
                with open(path, "rb") as stream:
                    self._hashes[key] = hashlib.file_digest(stream, "sha256").hexdigest()
            facts["sha256"] = self._hashes[key]
        return facts

    def same(self, recorded: Document, path: Path) -> bool:
        """True if the file at `path` is the recorded one: of its size and time, or of its content."""
        try:
            state = path.stat()
            if state.st_size != recorded["size"]:
                return False
            if state.st_mtime_ns == recorded["mtime_ns"]:
                return True
            return bool(recorded["sha256"]) and bool(self.of(path)["sha256"] == recorded["sha256"])
        except (OSError, ValueError, KeyError, TypeError):
            return False


@functools.cache
def core_digest() -> str:
    """Tells one build of the core from another, on any machine: version, and content of the compiled files."""
    core = native.load()
    folder = Path(core.__file__).parent
    files = sorted(folder.glob("*.so")) if folder.name == "penumbra_core" else [Path(core.__file__)]
    content = hashlib.sha256()
    for file in files:
        content.update(file.read_bytes())
    return f"{core.__version__} {content.hexdigest()[:16]}"


def made_from(item: Item, files: Sequence[Document]) -> Document:
    """The stamp of a result. files: facts of the scene, then of all that it reads."""
    return {"penumbra": __version__, "core": core_digest(), "asked": item.asked(), "files": list(files)}


@dataclass(frozen=True)
class State:
    """What there is of an item."""

    done: bool
    why_not: str = ""  # "new", or what has changed
    document: Document = field(default_factory=dict)


class Store:
    def __init__(self, out: Path) -> None:
        self.out = out
        self._hidden = out / ".penumbra"
        self._facts = Facts()

    # --- places ------------------------------------------------------------------------------------------------------

    def result(self, item: Item) -> Path:
        """The item's folder, or its picture."""
        if item.mode == "compare":
            return self.out / item.id
        scene, _, rest = item.id.partition("/")
        match = re.fullmatch(r"(-?\d+|current)(?:-(.+))?", rest)
        assert match is not None
        camera = [match[2]] if match[2] else []
        return self.out.joinpath(scene, *camera, f"{scene}_{match[1]}.{item.format}")

    def page(self, item: Item) -> Path:
        """What a person opens."""
        result = self.result(item)
        return result / "report.html" if item.mode == "compare" else result

    def _document_path(self, item: Item) -> Path:
        if item.mode == "compare":
            return self.result(item) / ITEM_FILE
        return self._hidden / "pictures" / f"{self.result(item).relative_to(self.out)}.json"

    def _failure_path(self, item: Item) -> Path:
        return self._hidden / "failed" / (item.id.replace("/", "--") + ".json")

    # --- what is there -----------------------------------------------------------------------------------------------

    def document(self, item: Item) -> Document | None:
        """item.json of a result that is there, whatever it was made from."""
        found = _read_json(self._document_path(item))
        return found if found is not None and self.page(item).is_file() else None

    def state(self, item: Item) -> State:
        """Whether the item has a result that was made from what is there now."""
        document = self.document(item)
        if document is None:
            return State(False, "new")
        if document.get("failures"):
            return State(False, "something failed the last time", document)
        return State(not (why := self._changed(item, document.get("made_from"))), why, document)

    def _changed(self, item: Item, stamp: object) -> str:
        if not isinstance(stamp, dict) or stamp.get("asked") != item.asked():
            return "other options"
        if stamp.get("core") != core_digest() or stamp.get("penumbra") != __version__:
            return "another build of Penumbra"
        files = stamp.get("files")
        if not isinstance(files, list) or not files or not self._facts.same(files[0], Path(item.scene)):
            return "the scene has changed"
        for facts in files[1:]:
            path = Path(str(facts.get("path", "")) if isinstance(facts, dict) else "")
            if not self._facts.same(facts, path):
                return f"{path.name} has changed"
        return ""

    def failure(self, item: Item) -> Document | None:
        return _read_json(self._failure_path(item))

    # --- putting things there ----------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def workplace(self) -> Iterator[Path]:
        """An empty folder to make a result in; it is gone when the block ends."""
        place = self._work / f"{_owner(os.getpid())}{secrets.token_hex(4)}"
        place.mkdir(parents=True)
        try:
            yield place
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def commit(self, item: Item, made: Path, document: Document) -> None:
        """Moves what was made (a folder, or a picture) to its place, over what was there."""
        target = self.result(item)
        target.parent.mkdir(parents=True, exist_ok=True)
        if item.mode == "compare":
            write_bytes(made / ITEM_FILE, _json_bytes(document))
            _replace_folder(made, target, self._work)
        else:
            # The old stamp goes first: no picture ever stands beside a stamp that is not its own.
            stamp = self._document_path(item)
            stamp.unlink(missing_ok=True)
            os.replace(made, target)
            stamp.parent.mkdir(parents=True, exist_ok=True)
            write_bytes(stamp, _json_bytes(document))
        self._failure_path(item).unlink(missing_ok=True)

    def fail(self, item: Item, reason: str, lines: Sequence[str]) -> None:
        """Notes why there is no result, for a summary that another process writes."""
        path = self._failure_path(item)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, _json_bytes({"reason": reason, "lines": list(lines)}))

    # --- tidying up --------------------------------------------------------------------------------------------------

    @property
    def _work(self) -> Path:
        return self._hidden / "work"

    def tidy(self, pid: int | None = None) -> None:
        """Removes what a process of this machine left behind when it was killed; by default, of all that have ended."""
        with contextlib.suppress(OSError):
            for place in list(self._work.iterdir()):
                match = re.fullmatch(re.escape(_host()) + r"-(\d+)-.*", place.name)
                if match and (int(match[1]) == pid if pid is not None else not _alive(int(match[1]))):
                    shutil.rmtree(place, ignore_errors=True)

    def close(self) -> None:
        """Leaves no empty folders behind."""
        for folder in (self._work, self._hidden / "failed", self._hidden):
            with contextlib.suppress(OSError):
                folder.rmdir()


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", socket.gethostname())[:40]


def _owner(pid: int) -> str:
    """How the name of a work folder begins: machines share the folder, so the process alone does not tell."""
    return f"{_host()}-{pid}-"


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    with contextlib.suppress(OSError):  # an orphan that nobody has buried yet is dead all the same
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in ("Z", "X")
    return True


def _replace_folder(made: Path, target: Path, work: Path) -> None:
    """Two names cannot change hands at once, so for an instant there is neither; never a mixture."""
    for _ in range(10):
        try:
            os.rename(made, target)
            return
        except OSError:
            if not target.exists():
                raise
        old = work / f"{_owner(os.getpid())}{secrets.token_hex(4)}-old"
        with contextlib.suppress(FileNotFoundError):  # another process was here first
            os.rename(target, old)
        shutil.rmtree(old, ignore_errors=True)
    raise OSError(f"{target} is being written by others")


def _read_json(path: Path) -> Document | None:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def _json_bytes(document: Document) -> bytes:
    return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode()
