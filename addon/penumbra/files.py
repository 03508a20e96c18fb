"""Writing files so that a killed run leaves none of them half written."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import unicodedata
from collections.abc import Iterator
from pathlib import Path

_TEMPORARY_PREFIX = ".penumbra-"


def write_bytes(path: Path, data: bytes) -> None:
    """Puts `data` at `path`, or leaves what was there; never anything in between."""
    with whole_file(path) as writable:
        writable.write_bytes(data)


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yields a path to write to; what was written appears as `path` when the block ends without an exception.

    On Linux the file has no name until it is complete (O_TMPFILE), so that not even SIGKILL leaves a partial one
    behind. Elsewhere it has a hidden temporary name, which is removed on any ordinary way out.
    """
    descriptor = _open_nameless(path.parent)
    if descriptor is None:
        with _named(path) as writable:
            yield writable
        return
    try:
        yield Path(f"/proc/self/fd/{descriptor}")
        _give_name(descriptor, path)
    finally:
        os.close(descriptor)


def _open_nameless(folder: Path) -> int | None:
    flag = getattr(os, "O_TMPFILE", None)
    if flag is None or not os.path.isdir("/proc/self/fd"):
        return None
    try:
        return os.open(folder, flag | os.O_RDWR, 0o666)
    except FileNotFoundError:
        raise
    except OSError:  # some file systems (NFS, overlay variants) have no nameless files
        return None


def _give_name(descriptor: int, path: Path) -> None:
    temporary = f"{_TEMPORARY_PREFIX}{secrets.token_hex(6)}.tmp"
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        # link() cannot replace a file, rename() can; what has the temporary name for an instant is complete.
        # The folder descriptor makes CPython call linkat(), the only form that follows the /proc link.
        os.link(f"/proc/self/fd/{descriptor}", temporary, dst_dir_fd=folder, follow_symlinks=True)
        try:
            os.replace(temporary, path.name, src_dir_fd=folder, dst_dir_fd=folder)
        except OSError:
            os.unlink(temporary, dir_fd=folder)
            raise
    finally:
        os.close(folder)


@contextlib.contextmanager
def _named(path: Path) -> Iterator[Path]:
    temporary = path.with_name(f"{_TEMPORARY_PREFIX}{secrets.token_hex(6)}{path.suffix}.tmp")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def why_not_writable(folder: Path) -> str:
    """Empty if files can be made in `folder` (which is made for the test and removed again), else the reason.

    Really tries: permission bits say little for the superuser, on read-only mounts and in /proc.
    """
    made: list[Path] = []
    try:
        missing = []
        existing = folder
        while not existing.exists() and existing != existing.parent:
            missing.append(existing)
            existing = existing.parent
        if not existing.is_dir():
            return f"{existing} is a file, not a folder"
        for step in reversed(missing):
            step.mkdir()
            made.append(step)
        probe = folder / f"{_TEMPORARY_PREFIX}{secrets.token_hex(6)}.tmp"
        probe.touch()
        probe.unlink()
    except OSError as error:
        return _lowered(error.strerror or str(error))
    finally:
        for step in reversed(made):
            with contextlib.suppress(OSError):
                step.rmdir()
    return ""


def _lowered(text: str) -> str:
    return text[:1].lower() + text[1:]


def slug(name: str) -> str:
    """A file name that every system takes: "Key Light.001" gives "key-light-001"."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return re.sub(r"[^a-z0-9]+", "-", plain.lower()).strip("-") or "unnamed"


def unique_slug(name: str, taken: list[str]) -> str:
    """slug(name), numbered if another has it already."""
    base = slug(name)
    chosen, number = base, 2
    while chosen in taken:
        chosen, number = f"{base}-{number}", number + 1
    return chosen
