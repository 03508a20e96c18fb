"""Items on the workers of a Dask cluster. Each Dask worker runs them in a worker process of ours (child.py), so that an
item that crashes takes neither the Dask worker nor its other tasks along, and a Dask worker that is lost is told from
an item that crashes: the scheduler gives a lost worker's item to another one, and only a crash counts as an attempt.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import UserError, sentence_of
from .child import Child
from .jobs import Item
from .local import ATTEMPTS, ITEMS_PER_WORKER, Outcome, Tell, times, wait_alone
from .store import Document, Store, core_digest

_CONNECT_S = 5.0
_TELL_S = 1.0
LOST_WORKERS = 5  # an item that was on so many lost workers is given up


def run(
    items: Sequence[Item],
    store: Store,
    address: str,
    tell: Tell,
    *,
    items_per_worker: int = ITEMS_PER_WORKER,
    timeout_s: float | None = None,
) -> Iterator[Outcome]:
    """Outcomes as they come. On Ctrl-C what has not begun is taken back; what runs is finished and kept.

    @raises UserError without Dask, without a scheduler at the address, or on a worker without Penumbra
    """
    try:
        import distributed
    except ImportError as error:
        raise UserError("Dask is not installed here; run: pip install 'penumbra[dask]'") from error
    by_key = {f"penumbra-{item.id}-{uuid.uuid4().hex[:8]}": item for item in items}
    with _connected(distributed, address) as client:
        order = {
            "out": str(store.out.resolve()),
            "core": core_digest(),
            "items_per_worker": items_per_worker,
            "timeout_s": timeout_s,
        }
        task = _task()
        futures = [
            client.submit(task, order | {"item": item.to_json()}, key=key, pure=False) for key, item in by_key.items()
        ]
        finished: Any = distributed.as_completed(futures, loop=client.loop)  # type: ignore[no-untyped-call]
        done = 0
        try:
            while done < len(futures):
                workers = len(client.scheduler_info(n_workers=-1)["workers"])
                running = "no worker is there" if workers == 0 else f"{workers} worker{'s' if workers != 1 else ''}"
                tell(float(done), f"{running} at {address}")
                for future in _next(finished, _TELL_S):
                    done += 1
                    yield _outcome(by_key[future.key], future)
        finally:
            client.cancel(futures, force=True)


def _connected(distributed: Any, address: str) -> Any:
    try:
        return distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise UserError(f"no Dask scheduler answers at {address}: {sentence_of(error)}") from error


def _next(finished: Any, seconds: float) -> list[Any]:
    """Futures that have finished, waiting for a while for the first one."""
    end = time.monotonic() + seconds
    while not (found := list(finished.next_batch(block=False))) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def _outcome(item: Item, future: Any) -> Outcome:
    if future.status == "finished":
        answer = future.result()
        if "document" in answer:
            return Outcome(item, "done", answer["document"], attempts=answer["attempts"])
        return Outcome(item, "failed", {}, answer["reason"], tuple(answer["lines"]), answer["attempts"])
    if future.status == "cancelled":
        return Outcome(item, "failed", reason="the cluster gave it back undone")
    error = future.exception()
    reason = f"{type(error).__name__}: {sentence_of(error)}"
    if type(error).__name__ == "KilledWorker":
        reason = f"the workers that it was on were lost, {LOST_WORKERS} of them or as many as the scheduler allows"
    elif isinstance(error, ModuleNotFoundError):
        reason = f"Penumbra is not installed on the Dask workers ({sentence_of(error)})"
    return Outcome(item, "failed", reason=reason)


def _task() -> Callable[[Document], Document]:
    """The function that travels to the workers, by value: in Blender this package has another name than there."""

    def penumbra_item(order: Document) -> Document:
        import importlib

        answer: Document = importlib.import_module("penumbra.batch.dask_farm").run_here(order)
        return answer

    return penumbra_item


# --- on a Dask worker ------------------------------------------------------------------------------------------------

_here = threading.local()  # one child per thread of the Dask worker


def run_here(order: Document) -> Document:
    """Does one item in a child of this Dask worker; a crashed one once more. The child stays for the next item."""
    item = Item.from_json(order["item"])
    store = Store(Path(order["out"]))
    reason, lines = "", list[str]()
    for attempt in range(1, ATTEMPTS + 1):
        child = _child(store, order["items_per_worker"])
        message = wait_alone(child, item, order["core"], order["timeout_s"])
        if message is not None and "done" in message:
            return {"document": message["done"], "attempts": attempt}
        lines = child.last_lines()
        if message is not None:
            reason = message["failed"]
            if message["final"]:
                return {"reason": reason, "lines": [], "attempts": attempt}
        else:
            reason = f"its worker process {child.ending()}"
        _drop()
    return {"reason": f"{reason}, {times(ATTEMPTS)}", "lines": lines, "attempts": ATTEMPTS}


def _child(store: Store, items_per_worker: int) -> Child:
    child: Child | None = getattr(_here, "child", None)
    if child is not None and (
        child.process.poll() is not None or child.items >= items_per_worker or child.store.out != store.out
    ):
        _drop()
        child = None
    if child is None:
        child = _here.child = Child(store)
    return child


def _drop() -> None:
    child: Child | None = getattr(_here, "child", None)
    if child is not None:
        child.close(kill=True)
        _here.child = None
