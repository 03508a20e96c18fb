"""Has Blender draw a viewport again when its worker has something new.

The workers' threads never call Blender, and a redraw that is asked for from another thread would wait for the next
event anyway. So a timer on Blender's thread looks while a worker is busy, and is gone when none is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from .worker import Worker

_INTERVAL_S = 0.02

_watched: dict[int, tuple[Worker[Any], Callable[[], None], int]] = {}  # with the version that was drawn


def watch(worker: Worker[Any], redraw: Callable[[], None]) -> None:
    """Calls `redraw` on Blender's thread for each answer, until the worker rests or is closed."""
    known = _watched.get(id(worker))
    _watched[id(worker)] = (worker, redraw, known[2] if known else worker.version)
    if not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=_INTERVAL_S)


def _look() -> float | None:
    for key, (worker, redraw, drawn) in list(_watched.items()):
        busy, version = worker.busy, worker.version
        if version != drawn:
            _watched[key] = (worker, redraw, version)
            redraw()
        if not busy:
            del _watched[key]
    return _INTERVAL_S if _watched else None


def unregister() -> None:
    _watched.clear()
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
