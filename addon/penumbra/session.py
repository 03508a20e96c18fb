"""The renderers that Blender's pictures come from: made when first needed, given back when nobody needs them.

A renderer owns a thread and an OpenGL context of its own; making one takes a tenth of a second and some memory.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

from . import native

_IDLE_S = 30.0

_lock = threading.Lock()
_kept: dict[tuple[str, str], Any] = {}  # one idle renderer per device and view, for the next picture
_open = 0


@contextlib.contextmanager
def renderer(device: str, view_by: str = "") -> Iterator[Any]:
    """A renderer for one picture; the next picture made in the same way gets the same one, warm.

    @raises UserError without the compiled core or for an unknown view, penumbra_core.DeviceError without a device
    """
    global _open
    core = native.load()
    machine = (device, native.view_by(view_by))
    with _lock:
        mine = _kept.pop(machine, None)
        _open += 1
    try:
        if mine is None:
            mine = native.renderer(core, *machine)
        yield mine
    except core.Cancelled:
        raise
    except core.Error:
        mine = None  # after an error nobody trusts it
        raise
    finally:
        with _lock:
            _open -= 1
            if mine is not None and machine not in _kept:
                _kept[machine] = mine
        mine = None
        _forget_later()


def release() -> None:
    """Gives back every renderer that is not at work."""
    with _lock:
        idle = list(_kept.values())
        _kept.clear()
    del idle


def count() -> tuple[int, int]:
    """Renderers kept, and at work: for tests."""
    with _lock:
        return len(_kept), _open


def _forget_later() -> None:
    """In Blender with a window a renderer that is idle for half a minute goes. In the background the process ends."""
    import bpy

    if bpy.app.background:
        return
    if bpy.app.timers.is_registered(_forget):
        bpy.app.timers.unregister(_forget)
    bpy.app.timers.register(_forget, first_interval=_IDLE_S, persistent=True)


def _forget() -> None:
    release()


def unregister() -> None:
    import bpy

    if bpy.app.timers.is_registered(_forget):
        bpy.app.timers.unregister(_forget)
    release()
