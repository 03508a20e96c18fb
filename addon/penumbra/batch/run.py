"""One batch from plan to summary."""

from __future__ import annotations

import contextlib
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from .. import errors
from ..progress import Progress
from .jobs import Item, Job, expand
from .local import LocalWorkers, Outcome, Tell
from .store import State, Store

Say = Callable[[str], None]


@dataclass(frozen=True)
class How:
    """How the work is done; none of it changes a result."""

    dask: str | None = None
    dry_run: bool = False
    overwrite: bool = False
    keep_existing: bool = False
    do_items: bool = True
    summary: bool = True
    items_per_worker: int = 50
    timeout_s: float | None = None
    given: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Planned:
    item: Item
    state: State

    @property
    def kept(self) -> bool:
        return self.state.done


def plan(items: list[Item], store: Store, how: How) -> list[Planned]:
    """What is done already and stays, and what is to be done and why."""
    planned = []
    for item in items:
        state = store.state(item)
        if how.overwrite and state.document:
            state = State(False, "to be overwritten", state.document)
        elif how.keep_existing and not state.done and (store.page(item).is_file()):
            state = State(True, "", state.document)
        planned.append(Planned(item, state))
    return planned


def plan_text(planned: list[Planned]) -> str:
    """ "12 items: 3 are done, 9 to do (7 new, 2 the scene has changed)"."""
    to_do = Counter(entry.state.why_not for entry in planned if not entry.kept)
    reasons = ", ".join(f"{count} {reason}" for reason, count in to_do.most_common())
    kept = len(planned) - sum(to_do.values())
    noun = "item" if len(planned) == 1 else "items"
    if not to_do:
        return f"{len(planned)} {noun}: all done before"
    return f"{len(planned)} {noun}: {kept} done before, {sum(to_do.values())} to do ({reasons})"


def run(job: Job, how: How, say: Say) -> int:
    """@return the exit code. Ctrl-C leaves what is finished in its place, and the next run goes on from there."""
    from . import summary

    items = expand(job)
    store = Store(job.out)
    planned = plan(items, store, how)
    print(plan_text(planned), flush=True)
    if how.dry_run:
        for entry in planned:
            print(f"  {entry.item.id:<28} {'done before' if entry.kept else entry.state.why_not}")
        return errors.OK
    to_do = [entry.item for entry in planned if not entry.kept] if how.do_items else []
    started = time.monotonic()
    store.tidy()
    store.close()
    outcomes: dict[str, Outcome] = {}
    if to_do:
        new = not store.out.exists()
        store.out.mkdir(parents=True, exist_ok=True)
        try:
            outcomes = _do(to_do, job, how, store)
        finally:
            store.close()
            if new:
                with contextlib.suppress(OSError):
                    store.out.rmdir()  # nothing came of it
    failed = [outcome for outcome in outcomes.values() if outcome.status == "failed"]
    results = [_result(entry, outcomes.get(entry.item.id), store, how) for entry in planned]
    if not how.summary:
        for outcome in failed:
            say(f"{outcome.item.id}: {outcome.reason}")
        return errors.FAILED if failed else errors.OK
    book = summary.collect(job, results, how.given, time.monotonic() - started)
    page = summary.write(book, job.out)
    return summary.conclude(book, page, say)


def _result(entry: Planned, outcome: Outcome | None, store: Store, how: How) -> Any:
    """What the summary shows of an item."""
    from .summary import Result

    if outcome is not None and outcome.status == "done":
        return Result(entry.item, store.page(entry.item), outcome.document, False, attempts=outcome.attempts)
    if outcome is not None:
        return Result(entry.item, None, {}, False, outcome.reason, outcome.lines, outcome.attempts)
    if entry.kept or (not how.do_items and entry.state.why_not == "something failed the last time"):
        return Result(entry.item, store.page(entry.item), entry.state.document, kept=True)
    noted = store.failure(entry.item) or {}
    reason = str(noted.get("reason") or f"not done ({entry.state.why_not})")
    return Result(entry.item, None, {}, False, reason, tuple(noted.get("lines", ())))


def _do(items: list[Item], job: Job, how: How, store: Store) -> dict[str, Outcome]:
    outcomes: dict[str, Outcome] = {}
    with Progress() as progress:
        progress.stage("batch", 1.0)
        clock = _Clock(len(items), progress, bar=sys.stderr.isatty())
        for outcome in _outcomes(items, job, how, store, clock.tell):
            outcomes[outcome.item.id] = outcome
            clock.done = len(outcomes)
            if outcome.status == "failed":
                store.fail(outcome.item, outcome.reason, outcome.lines)
                progress.note(f"{outcome.item.id} failed: {outcome.reason}")
            elif outcome.attempts > 1:
                progress.note(f"{outcome.item.id} is done at the second attempt")
        progress.finish()
    return outcomes


def _outcomes(items: list[Item], job: Job, how: How, store: Store, tell: Tell) -> Iterator[Outcome]:
    if how.dask is not None:
        from . import dask_farm

        yield from dask_farm.run(
            items, store, how.dask, tell, items_per_worker=how.items_per_worker, timeout_s=how.timeout_s
        )
        return
    workers = LocalWorkers(
        store, min(job.workers, len(items)), items_per_worker=how.items_per_worker, timeout_s=how.timeout_s
    )
    with workers:
        yield from workers.run(items, tell)


class _Clock:
    """Puts the work of all workers on one bar, or on a line with the time that is left."""

    def __init__(self, total: int, progress: Progress, *, bar: bool) -> None:
        self._total = total
        self._progress = progress
        self._bar = bar
        self._started = time.monotonic()
        self.done = 0

    def tell(self, reached: float, text: str) -> None:
        words = f"{self.done} of {self._total} items"
        if not self._bar and reached > 0:  # the bar has its own
            words += f", {_duration((time.monotonic() - self._started) * (self._total - reached) / reached)} left"
        self._progress(reached / self._total, f"{words}; {text}" if text else words)


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
