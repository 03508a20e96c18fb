"""A worker process of the batch as its parent sees it."""

from __future__ import annotations

from ..processes import Worker
from .jobs import Item
from .store import Store, core_digest


class Child(Worker):
    def __init__(self, store: Store, variables: dict[str, str] | None = None, *, workers: int = 1) -> None:
        """workers: how many share the machine, which is noted in every result."""
        super().__init__("batch-worker", variables)
        self.store = store
        self._workers = workers
        self.items = 0
        self.scene = ""

    def give(self, item: Item, core: str | None = None) -> None:
        """core: digest of the core that the batch was started with, where that was elsewhere.

        @raises OSError if the process has ended
        """
        self.items += 1
        self.scene = item.scene
        self.order(
            {
                "item": item.to_json(),
                "out": str(self.store.out.resolve()),
                "core": core or core_digest(),
                "workers": self._workers,
            }
        )

    def close(self, *, kill: bool = False) -> None:
        super().close(kill=kill)
        self.store.tidy(self.process.pid)
