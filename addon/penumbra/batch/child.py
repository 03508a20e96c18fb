"""A worker process as its parent sees it."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

from .. import native
from ..blender_command import NAME
from ..commands.scene import inside_blender
from .jobs import Item
from .store import Store, core_digest

LAST_LINES = 12
_LEAVING_S = 10.0


def command(descriptor: int) -> list[str]:
    """How this very Penumbra is started once more: in Blender by Blender, with the user's add-ons."""
    own = ["batch-worker", "--channel", str(descriptor)]
    if inside_blender():
        return [str(sys.modules["bpy"].app.binary_path), "--background", "--command", NAME, *own]
    return [sys.executable, "-m", __package__.partition(".")[0], *own]


class Child:
    """Starts at once, and takes a first item while it is still starting."""

    def __init__(self, store: Store, variables: dict[str, str] | None = None, *, workers: int = 1) -> None:
        """workers: how many share the machine, which is noted in every result."""
        self.store = store
        self._workers = workers
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close())
        # Blender leaves its temporary folder behind when it is killed.
        self._temporary = tempfile.mkdtemp(prefix="penumbra-worker-")
        self.channel, theirs = Pipe()
        with theirs:
            self.process = subprocess.Popen(
                command(theirs.fileno()),
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=self._output,
                stderr=subprocess.STDOUT,
                env=os.environ | {"TMPDIR": self._temporary} | _paths() | (variables or {}),
                start_new_session=True,  # Ctrl-C is the parent's to hear
            )
        self.ready = False
        self.items = 0
        self.scene = ""
        self._closed = False

    def give(self, item: Item, core: str | None = None) -> None:
        """core: digest of the core that the batch was started with, where that was elsewhere.

        @raises OSError if the process has ended
        """
        self.items += 1
        self.scene = item.scene
        order = {
            "item": item.to_json(),
            "out": str(self.store.out.resolve()),
            "core": core or core_digest(),
            "workers": self._workers,
        }
        self.channel.send_bytes(json.dumps(order).encode())

    def hear(self) -> dict[str, Any] | None:
        """The next message, or None when the process has ended."""
        try:
            message: dict[str, Any] = json.loads(self.channel.recv_bytes())
        except (EOFError, OSError):
            return None
        if "ready" in message:
            self.ready = True
        return message

    def ending(self) -> str:
        """How the process ended, in words: "died of SIGSEGV"."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(_LEAVING_S)
        code = self.process.returncode
        if code is not None and code < 0:
            with contextlib.suppress(ValueError):
                return f"died of {signal.Signals(-code).name}"
        return f"ended with exit code {code}" if code is not None else "closed its pipe"

    def last_lines(self) -> list[str]:
        """What the process printed last."""
        size = os.fstat(self._output.fileno()).st_size
        text = os.pread(self._output.fileno(), 1 << 16, max(0, size - (1 << 16))).decode("utf-8", "replace")
        lines = [line.rstrip() for line in text.splitlines() if line.strip()]
        # A crash is told at the top of the trace; its end are the frames of the interpreter's start.
        marks = [i for i, line in enumerate(lines) if line.startswith("Fatal Python error")]
        return lines[max(0, marks[-1] - 2) :][:LAST_LINES] if marks else lines[-LAST_LINES:]

    def close(self, *, kill: bool = False) -> None:
        """The process leaves when it has nothing to do, or at once."""
        if self._closed:
            return
        self._closed = True
        if kill:
            self.kill()
        self.channel.close()
        try:
            self.process.wait(_LEAVING_S)
        except subprocess.TimeoutExpired:
            self.kill()
        self._output.close()
        shutil.rmtree(self._temporary, ignore_errors=True)
        self.store.tidy(self.process.pid)

    def kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


def _paths() -> dict[str, str]:
    """Where this process found the package and its core, unless every Python looks there: a checkout is on no path."""
    if inside_blender():
        return {}
    found = [Path(__file__).resolve().parents[2], Path(native.load().__file__).resolve().parents[1]]
    installed = [Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")]
    own = [str(path) for path in found if path not in installed]
    given = [path for path in (os.environ.get("PYTHONPATH"),) if path]
    return {"PYTHONPATH": os.pathsep.join([*own, *given])} if own else {}
