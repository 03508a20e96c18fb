"""All techniques on all cases, in a process that may crash, hang or want too much memory without ending the run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence

from ..errors import UserError
from ..processes import Worker
from . import limits
from .cases import Case
from .rows import Measured, Row

TABLE = "penumbra.stability.cases"
_START_S = 120.0
_SLACK_S = 60.0  # the truth of a case is made in the same process, in nobody's time

Tell = Callable[[float, str], None]
"""tell(cases done, the one at work)"""


class Measurer:
    """One worker process at a time; use it in a `with` block."""

    def __init__(self, device: str = "", view_by: str = "", table: str = TABLE) -> None:
        self._common = {"table": table, "device": device, "view_by": view_by}
        self._worker: Worker | None = None

    def __enter__(self) -> Measurer:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._drop(kill=kind is not None)

    def rows(self, technique: str, case: Case) -> list[Row]:
        """@raises UserError if no process can be started"""
        worker = self._started()
        try:
            worker.order(self._common | {"case": case.id, "technique": technique})
        except OSError:
            return self._lost(technique, case, worker)
        end = time.monotonic() + case.ends_s + _SLACK_S
        while worker.channel.poll(max(0.0, end - time.monotonic())):
            message = worker.hear()
            if message is None:
                return self._lost(technique, case, worker)
            if "failed" in message:
                self._drop(kill=True)  # what went wrong once in it may stay wrong
                return [_violated(technique, case, message["failed"])]
            if "found" in message:
                found = (Measured(*entry) for entry in message["found"])
                return limits.judge(technique, case.id, found, message["warnings"])
        self._drop(kill=True)
        return [_violated(technique, case, f"it had not ended after {case.ends_s + _SLACK_S:g} s")]

    def _started(self) -> Worker:
        if self._worker is None:
            worker = self._worker = Worker("stability-worker")
            if not worker.channel.poll(_START_S) or worker.hear() is None:
                how, lines = worker.ending(), worker.last_lines()
                self._drop(kill=True)
                raise UserError(
                    f"no worker process can be started: it {how}; its last words: {(lines or ['none'])[-1]}"
                )
        return self._worker

    def _lost(self, technique: str, case: Case, worker: Worker) -> list[Row]:
        reason = f"the process {worker.ending()}"
        lines = worker.last_lines()
        self._drop(kill=True)
        return [_violated(technique, case, "; ".join([reason, *lines[:1]]))]

    def _drop(self, *, kill: bool) -> None:
        if self._worker is not None:
            self._worker.close(kill=kill)
            self._worker = None


def run(
    techniques: Sequence[str],
    cases: Sequence[Case],
    tell: Tell,
    *,
    device: str = "",
    view_by: str = "",
    table: str = TABLE,
) -> Iterator[Row]:
    """Rows case by case: the techniques of a case share its scenes and its truth."""
    with Measurer(device, view_by, table) as measurer:
        for done, case in enumerate(cases):
            for number, technique in enumerate(techniques):
                tell(done + number / len(techniques), f"{case.id}: {technique}")
                yield from measurer.rows(technique, case)


def _violated(technique: str, case: Case, reason: str) -> Row:
    return Row(technique, case.id, "ends", None, case.ends_s, "violated", reason)
