"""The worker process: takes items from a pipe, one after another, and tells how each goes.

It is started by child.py as `penumbra batch-worker`, as Blender itself where the batch runs in Blender. Messages are
JSON: to the worker {"item", "out", "core", "workers"}; from it {"ready"} once, then per item any number
of {"progress": [share, text]} and one of {"done": item.json} or {"failed": sentence, "final": bool}.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import json
import os
import signal
import sys
import time
import traceback
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import interrupts
from ..errors import UserError, sentence_of
from ..progress import ToldProgress

if TYPE_CHECKING:
    from .work import Workbench

_TELL_INTERVAL_S = 0.2
_IDLE_S = 120.0  # then it goes: on a farm nobody says that a batch is over
_PR_SET_PDEATHSIG = 1


def serve(descriptor: int) -> int:
    """Works until the other end of the pipe is closed. @return exit code"""
    _die_with_parent()
    # Beside the streams: while Blender reads, these are caught (scenes.quiet), and would be lost with the process.
    faulthandler.enable(os.fdopen(os.dup(2), "w"))
    channel = Connection(descriptor)
    with interrupts.held():
        from . import work

        bench = work.Workbench()
    try:
        _send(channel, {"ready": os.getpid()})
        while channel.poll(_IDLE_S):
            order = json.loads(channel.recv_bytes())
            _send(channel, _answer(bench, order, channel))
        return 0
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return 0


def _answer(bench: Workbench, order: dict[str, Any], channel: Connection) -> dict[str, Any]:
    from .jobs import Item

    told_at = 0.0

    def tell(share: float, text: str) -> None:
        nonlocal told_at
        if time.monotonic() - told_at > _TELL_INTERVAL_S:
            told_at = time.monotonic()
            _send(channel, {"progress": [share, text]})

    try:
        item, out = Item.from_json(order["item"]), Path(order["out"])
        return {"done": bench.do(item, out, order["core"], order["workers"], ToldProgress(tell))}
    except UserError as error:
        return {"failed": str(error), "final": True}
    except (BrokenPipeError, ConnectionResetError):
        raise
    except BaseException as error:  # KeyboardInterrupt is how the core says that it was stopped
        traceback.print_exc()
        sys.stderr.flush()
        what = "out of memory" if isinstance(error, MemoryError) else sentence_of(error)
        return {"failed": f"{what} ({type(error).__name__})", "final": False}


def _send(channel: Connection, message: dict[str, Any]) -> None:
    channel.send_bytes(json.dumps(message).encode())


def _die_with_parent() -> None:
    """However the parent ends: nobody is left to take the results. Linux alone has this; elsewhere the item that is
    being made is finished first."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
