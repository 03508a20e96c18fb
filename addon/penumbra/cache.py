"""References kept between runs: tracing one takes longer than everything else of a comparison. Beside them lie the
pictures of comparisons made in Blender (comparison/pictures.py).
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import zipfile
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from .errors import UserError
from .files import whole_file
from .records import ReferenceResult

# Part of every key: raised when the meaning of a reference or the file's layout changes.
_LAYOUT = 1
_ARRAYS = ("area", "irradiance", "standard_error", "irradiance_standard_error", "mask")
_SUFFIX = ".reference.npz"
_SUFFIXES = (_SUFFIX, ".comparison.npz")  # of all that is kept here
DEFAULT_BYTES = 2 << 30
_UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}


def folder() -> Path:
    """$PENUMBRA_CACHE, else $XDG_CACHE_HOME/penumbra, else ~/.cache/penumbra."""
    own = os.environ.get("PENUMBRA_CACHE")
    if own:
        return Path(own)
    shared = os.environ.get("XDG_CACHE_HOME")
    return Path(shared) / "penumbra" if shared else Path.home() / ".cache" / "penumbra"


def capacity() -> int:
    """$PENUMBRA_CACHE_SIZE in bytes, or with a unit ("500M", "2G", "2GiB"); 2 GiB if it is not set."""
    text = os.environ.get("PENUMBRA_CACHE_SIZE", "").strip().lower()
    if not text:
        return DEFAULT_BYTES
    number = text.removesuffix("ib").removesuffix("b")
    unit = number[-1:] if number[-1:].isalpha() else ""
    try:
        size = float(number.removesuffix(unit)) * _UNITS[unit]
        if not 0 <= size < 1 << 60:
            raise ValueError
    except (ValueError, KeyError):
        raise UserError(f'PENUMBRA_CACHE_SIZE is "{text}"; give bytes or a size such as 500M or 2G') from None
    return int(size)


def key(**parts: Any) -> str:
    """SHA-256 over everything that a reference depends on; the order of the arguments does not matter."""
    text = json.dumps({"layout": _LAYOUT, **parts}, sort_keys=True, allow_nan=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class ReferenceCache:
    """A folder of files, one per reference; several processes may use it at once.

    A file is written whole or not at all, so that a reader never sees a part of one; a file that cannot be read is
    a miss. What has not been used for longest goes first when the folder grows over `max_bytes`. A folder that
    cannot be written to is no error: it caches nothing.
    """

    root: Path
    max_bytes: int = DEFAULT_BYTES

    @staticmethod
    def of_user() -> ReferenceCache:
        return ReferenceCache(folder(), capacity())

    def _path(self, entry: str) -> Path:
        return self.root / f"{entry}{_SUFFIX}"

    def load(self, entry: str) -> ReferenceResult | None:
        """The reference kept under this key, or None."""
        path = self._path(entry)
        try:
            with np.load(path, allow_pickle=False) as file:
                facts = json.loads(bytes(file["facts"]).decode())
                arrays = {name: file[name] for name in _ARRAYS}
            if facts.pop("key") != entry or len({array.shape for array in arrays.values()}) != 1:
                return None
            result = ReferenceResult(**arrays, **facts)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile, zlib.error):
            with contextlib.suppress(OSError):
                path.unlink()  # corrupted: trace it again
            return None
        with contextlib.suppress(OSError):
            os.utime(path)  # used just now
        result.from_cache = True
        return result

    def store(self, entry: str, reference: ReferenceResult) -> bool:
        """Keeps a reference; False if the folder does not take it."""
        facts = {field.name: getattr(reference, field.name) for field in fields(reference) if field.name not in _ARRAYS}
        facts |= {"key": entry, "from_cache": False}
        buffer = io.BytesIO()
        np.savez(  # uncompressed: the zip's checksum guards it, and reading is then one copy
            buffer,
            facts=np.frombuffer(json.dumps(facts).encode(), np.uint8),
            **{name: getattr(reference, name) for name in _ARRAYS},
        )
        return self.keep(self._path(entry).name, buffer.getbuffer())

    def keep(self, name: str, data: bytes | memoryview) -> bool:
        """Keeps a file of this name, which ends as one of ours; False if the folder does not take it."""
        assert name.endswith(_SUFFIXES)
        if len(data) > self.max_bytes:
            return False
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            self._make_room(len(data))
            with whole_file(self.root / name) as writable, open(writable, "wb") as file:
                file.write(data)
        except OSError:
            return False
        return True

    def size_bytes(self) -> int:
        return sum(size for _, size, _ in self._entries())

    def entries(self) -> int:
        return len(self._entries())

    def _entries(self) -> list[tuple[float, int, Path]]:
        """(last use, bytes, path), the longest unused first."""
        found = []
        with contextlib.suppress(OSError), os.scandir(self.root) as listing:
            for item in listing:
                if item.name.endswith(_SUFFIXES):
                    with contextlib.suppress(OSError):  # another process may just have removed it
                        status = item.stat()
                        found.append((status.st_mtime, status.st_size, Path(item.path)))
        return sorted(found, key=lambda entry: entry[0])

    def _make_room(self, needed: int) -> None:
        entries = self._entries()
        total = sum(size for _, size, _ in entries) + needed
        for _, size, path in entries:
            if total <= self.max_bytes:
                return
            path.unlink(missing_ok=True)
            total -= size


def describe(cache: ReferenceCache) -> dict[str, Any]:
    """For `penumbra doctor`."""
    return {
        "folder": str(cache.root),
        "entries": cache.entries(),
        "bytes": cache.size_bytes(),
        "max_bytes": cache.max_bytes,
    }
