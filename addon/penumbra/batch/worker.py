"""The worker process of the batch: takes items from a pipe, one after another, and tells how each goes.

It is started by child.py as `penumbra batch-worker`, as Blender itself where the batch runs in Blender. Messages (see
processes.py): to the worker {"item", "out", "core", "workers"}; from it, last, {"done": item.json} or
{"failed": sentence, "final": bool}.
"""

from __future__ import annotations

import sys
import traceback
from pathlib import Path

from .. import interrupts, processes
from ..errors import UserError, sentence_of
from ..progress import ToldProgress


def serve(descriptor: int) -> int:
    """Works until the other end of the pipe is closed. @return exit code"""
    return processes.serve(descriptor, _begin)


def _begin() -> processes.Answer:
    with interrupts.held():
        from . import work

        bench = work.Workbench()

    def answer(order: processes.Message, tell: processes.Tell) -> processes.Message:
        from .jobs import Item

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

    return answer
