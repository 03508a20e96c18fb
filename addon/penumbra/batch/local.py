"""Items on worker processes of this machine: one item at a time each, a crashed item once more, the others go on."""

from __future__ import annotations

import math
import os
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import Any, Literal, cast

from ..environment import usable_cores
from ..errors import UserError
from .child import Child
from .jobs import Item
from .store import Document, Store

ATTEMPTS = 2
ITEMS_PER_WORKER = 50  # then a fresh one: whatever leaks, in Blender or in us, is bounded
_PATIENCE_S = 0.25


@dataclass(frozen=True)
class Outcome:
    item: Item
    status: Literal["done", "failed"]
    document: Document = field(default_factory=dict)  # item.json
    reason: str = ""
    lines: tuple[str, ...] = ()  # what a crashed worker printed last
    attempts: int = 1


Tell = Callable[[float, str], None]
"""tell(items done, with the shares of those at work; what is going on)"""


@dataclass
class _Hand:
    child: Child | None = None
    item: Item | None = None
    share: float = 0.0
    text: str = ""
    since: float = 0.0


class LocalWorkers:
    """Worker processes that live as long as this object; use it in a `with` block."""

    def __init__(
        self, store: Store, workers: int, *, items_per_worker: int = ITEMS_PER_WORKER, timeout_s: float | None = None
    ) -> None:
        self._store = store
        self._hands = [_Hand() for _ in range(workers)]
        self._items_per_worker = items_per_worker
        self._timeout_s = timeout_s
        self._attempts: Counter[str] = Counter()
        self._pending: deque[Item] = deque()
        self._stillborn = 0
        self._variables = _share_of_machine(workers)

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        for hand in self._hands:  # all are told first, so that they leave at the same time
            if hand.child is not None:
                hand.child.channel.close() if kind is None else hand.child.kill()
        for hand in self._hands:
            if hand.child is not None:
                hand.child.close(kill=kind is not None)
                hand.child = None

    def run(self, items: Sequence[Item], tell: Tell) -> Iterator[Outcome]:
        """Outcomes as they come. @raises UserError if no worker can be started at all"""
        self._pending.extend(items)
        done = 0
        while self._pending or any(hand.item for hand in self._hands):
            for hand in self._hands:
                if hand.item is None and self._pending:
                    self._give(hand)
            for hand in self._ready():
                outcome = self._hear(hand)
                if outcome is not None:
                    done += 1
                    yield outcome
            busy = [hand for hand in self._hands if hand.item is not None]
            text = "; ".join(f"{hand.item.id}: {hand.text}" for hand in busy if hand.item and hand.text)
            tell(done + sum(hand.share for hand in busy), text)

    def _give(self, hand: _Hand) -> None:
        if hand.child is not None and hand.child.items >= self._items_per_worker:
            hand.child.close()
            hand.child = None
        if hand.child is None:
            hand.child = Child(self._store, self._variables, workers=len(self._hands))
        item = self._next(hand.child.scene)
        hand.item, hand.share, hand.text, hand.since = item, 0.0, "", time.monotonic()
        try:
            hand.child.give(item)
        except OSError:  # it died while it had nothing to do, which is nobody's fault
            self._drop(hand)
            self._pending.appendleft(item)

    def _next(self, scene: str) -> Item:
        """An item of the scene that the worker has open, else of one that nobody has, else of the next one."""
        pending = self._pending
        open_elsewhere = {hand.item.scene for hand in self._hands if hand.item is not None}
        chosen = next((item for item in pending if item.scene == scene), None)
        chosen = chosen or next((item for item in pending if item.scene not in open_elsewhere), None) or pending[0]
        pending.remove(chosen)
        return chosen

    def _ready(self) -> list[_Hand]:
        hands = {hand.child.channel: hand for hand in self._hands if hand.child is not None and hand.item is not None}
        speaking = cast("list[Connection]", wait(list(hands), _PATIENCE_S))
        found = {id(hands[channel]): hands[channel] for channel in speaking}
        for hand in hands.values():
            late = self._timeout_s is not None and time.monotonic() - hand.since > self._timeout_s
            if late and hand.child is not None and hand.child.ready:
                hand.child.kill()
                found[id(hand)] = hand
        return list(found.values())

    def _hear(self, hand: _Hand) -> Outcome | None:
        """The outcome of the hand's item, if the message brings one."""
        child, item = hand.child, hand.item
        assert child is not None and item is not None
        message = child.hear()
        if message is None:
            return self._ended(hand, child, item)
        if "progress" in message:
            hand.share, hand.text = message["progress"]
        elif "ready" in message:
            self._stillborn, hand.since = 0, time.monotonic()
        elif "done" in message:
            hand.item = None
            return Outcome(item, "done", message["done"], attempts=self._attempts[item.id] + 1)
        elif message["final"]:
            hand.item = None
            return Outcome(item, "failed", reason=message["failed"], attempts=self._attempts[item.id] + 1)
        else:
            lines = child.last_lines()
            self._drop(hand)  # what went wrong once in it may stay wrong
            return self._once_more(item, message["failed"], lines)
        return None

    def _ended(self, hand: _Hand, child: Child, item: Item) -> Outcome | None:
        late = self._timeout_s is not None and time.monotonic() - hand.since > self._timeout_s
        how, lines, ready = child.ending(), child.last_lines(), child.ready
        self._drop(hand)
        if not ready:
            self._stillborn += 1
            if self._stillborn > len(self._hands):
                raise UserError(f"no worker process can be started: it {how}; its last words: {_last(lines)}")
            self._pending.appendleft(item)
            return None
        reason = f"it took longer than {self._timeout_s:g} s" if late else f"its worker process {how}"
        return self._once_more(item, reason, lines)

    def _once_more(self, item: Item, reason: str, lines: list[str]) -> Outcome | None:
        self._attempts[item.id] += 1
        if self._attempts[item.id] < ATTEMPTS:
            self._pending.appendleft(item)
            return None
        attempts = self._attempts[item.id]
        return Outcome(item, "failed", reason=f"{reason}, {times(attempts)}", lines=tuple(lines), attempts=attempts)

    def _drop(self, hand: _Hand) -> None:
        if hand.child is not None:
            hand.child.close(kill=True)
        hand.child = hand.item = None


def times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _last(lines: Sequence[str]) -> str:
    return lines[-1] if lines else "none"


def _share_of_machine(workers: int) -> dict[str, str]:
    """Several workers share the cores instead of each taking all of them. One worker keeps what was set."""
    if workers == 1:
        return {}
    share = str(max(1, usable_cores() // workers))
    names: tuple[str, ...] = ("PENUMBRA_THREADS", "LP_NUM_THREADS", "OMP_NUM_THREADS")
    return {name: share for name in names if name not in os.environ}


def wait_alone(child: Child, item: Item, core: str, timeout_s: float | None) -> dict[str, Any] | None:
    """Gives one item to one worker and waits: the last message, or None when the worker has died or is too late."""
    try:
        child.give(item, core)
    except OSError:
        return None
    end = time.monotonic() + timeout_s if timeout_s is not None else math.inf
    while True:
        left = end - time.monotonic()
        if math.isfinite(left) and not child.channel.poll(max(0.0, left)):
            child.kill()
            return None
        message = child.hear()
        if message is None or "done" in message or "failed" in message:
            return message
