"""The worker process of `penumbra stability`: measures one technique on one case at a time.

Messages (processes.py): to it {"table", "case", "technique", "device", "view_by"}, where the table is a module with
CASES; from it {"found": [[property, value, bound, {closed form: bound}]], "warnings": [sentence]} or
{"failed": sentence}.
"""

from __future__ import annotations

import contextlib
import importlib
import resource
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from .. import processes
from ..errors import sentence_of

if TYPE_CHECKING:
    from .cases import Case

# A process that wants more than this many times what a case may take is refused it, and the machine goes on.
_HARD_LIMIT = 4


def serve(descriptor: int) -> int:
    """@return exit code"""
    return processes.serve(descriptor, _begin)


def _begin() -> processes.Answer:
    from .. import native
    from .bench import Bench, resident_mb
    from .rows import Measured

    core = native.load()
    benches: dict[tuple[str, str], Bench] = {}

    def answer(order: processes.Message, tell: processes.Tell) -> processes.Message:
        case = _case(order["table"], order["case"])
        _limit_memory(_HARD_LIMIT * case.memory_mb)
        before_mb = resident_mb()
        _forget_peak()
        try:
            machine = (order["device"], order["view_by"])
            if machine not in benches:
                benches[machine] = Bench(core, *machine)
            found, warnings = benches[machine].measure(case, order["technique"])
        except Exception as error:
            traceback.print_exc()
            sys.stderr.flush()
            what = "out of memory" if isinstance(error, MemoryError) else sentence_of(error)
            return {"failed": f"{what} ({type(error).__name__})"}
        if found:
            found = [*found, Measured("memory", max(_peak_mb() - before_mb, 0.0), case.memory_mb)]
        return {"found": [[m.property, m.value, m.bound, dict(m.forms)] for m in found], "warnings": warnings}

    return answer


def _case(table: str, id_: str) -> Case:
    cases: tuple[Case, ...] = importlib.import_module(table).CASES
    return next(case for case in cases if case.id == id_)


def _limit_memory(megabytes: float) -> None:
    """Of what the process may write to; the rest (code, files) is not counted."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = int(megabytes * 1024 * 1024)
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard < 0 else min(wanted, hard), hard))


def _forget_peak() -> None:
    """The peak of memory counts from here on, where the system lets us (Linux, and not in every container)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _peak_mb() -> float:
    """Most memory in use since _forget_peak(), else since the start."""
    with contextlib.suppress(OSError, IndexError, ValueError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
