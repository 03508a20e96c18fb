"""Worker processes: JSON messages over a pipe, however the process at the other end fares.

The parent holds a Worker, the child calls serve(). A child first sends {"ready": pid}; then it answers each order with
any number of {"progress": [share, text]} and one last message, of which the two ends agree between themselves.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from . import native
from .blender_command import NAME
from .commands.scene import inside_blender

Message = dict[str, Any]
Tell = Callable[[float, str], None]
"""tell(share of the order that is done, what is going on)"""
Answer = Callable[[Message, Tell], Message]

LAST_LINES = 12
_LEAVING_S = 10.0
_TELL_INTERVAL_S = 0.2
_IDLE_S = 120.0  # then a child goes: on a farm nobody says that a batch is over
_PR_SET_PDEATHSIG = 1


def command(subcommand: str, descriptor: int) -> list[str]:
    """How this very Penumbra is started once more: in Blender by Blender, with the user's add-ons."""
    own = [subcommand, "--channel", str(descriptor)]
    if inside_blender():
        return [str(sys.modules["bpy"].app.binary_path), "--background", "--command", NAME, *own]
    return [sys.executable, "-m", __package__, *own]


class Worker:
    """A process of its own. Starts at once, and takes a first order while it is still starting."""

    def __init__(self, subcommand: str, variables: dict[str, str] | None = None) -> None:
        """subcommand: of `penumbra`, which calls serve() with the number of --channel."""
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close())
        # Blender leaves its temporary folder behind when it is killed.
        self._temporary = tempfile.mkdtemp(prefix="penumbra-worker-")
        self.channel, theirs = Pipe()
        with theirs:
            self.process = subprocess.Popen(
                command(subcommand, theirs.fileno()),
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=self._output,
                stderr=subprocess.STDOUT,
                env=os.environ | {"TMPDIR": self._temporary} | _paths() | (variables or {}),
                start_new_session=True,  # Ctrl-C is the parent's to hear
            )
        self.ready = False
        self._closed = False

    def order(self, message: Message) -> None:
        """@raises OSError if the process has ended"""
        self.channel.send_bytes(json.dumps(message).encode())

    def hear(self) -> Message | None:
        """The next message, or None when the process has ended."""
        try:
            message: Message = json.loads(self.channel.recv_bytes())
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

    def kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


def serve(descriptor: int, begin: Callable[[], Answer]) -> int:
    """Works until the other end of the pipe is closed. @return exit code

    begin: what is loaded once, before "ready"; gives the function that answers an order.
    """
    _die_with_parent()
    # Beside the streams: while Blender reads, these are caught (scenes.quiet), and would be lost with the process.
    faulthandler.enable(os.fdopen(os.dup(2), "w"))
    channel = Connection(descriptor)
    answer = begin()
    try:
        _send(channel, {"ready": os.getpid()})
        while channel.poll(_IDLE_S):
            order = json.loads(channel.recv_bytes())
            _send(channel, answer(order, _teller(channel)))
        return 0
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return 0


def _teller(channel: Connection) -> Tell:
    told_at = 0.0

    def tell(share: float, text: str) -> None:
        nonlocal told_at
        if time.monotonic() - told_at > _TELL_INTERVAL_S:
            told_at = time.monotonic()
            _send(channel, {"progress": [share, text]})

    return tell


def _send(channel: Connection, message: Message) -> None:
    channel.send_bytes(json.dumps(message).encode())


def _die_with_parent() -> None:
    """However the parent ends: nobody is left to take the results. Linux alone has this; elsewhere the order that is
    being carried out is finished first."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _paths() -> dict[str, str]:
    """Where this process found the package and its core, unless every Python looks there: a checkout is on no path."""
    if inside_blender():
        return {}
    found = [Path(__file__).resolve().parents[1], Path(native.load().__file__).resolve().parents[1]]
    installed = [Path(sysconfig.get_path(name)).resolve() for name in ("purelib", "platlib")]
    own = [str(path) for path in found if path not in installed]
    given = [path for path in (os.environ.get("PYTHONPATH"),) if path]
    return {"PYTHONPATH": os.pathsep.join([*own, *given])} if own else {}
