"""Switching the add-on on and off: every part registers itself, and what is registered is taken back in reverse."""

from __future__ import annotations

import atexit
import sys
from pathlib import Path
from typing import Protocol

from . import blender_command, compositor, engine, preferences, properties, session
from .comparison import operators as comparison_operators
from .comparison import properties as comparison_properties
from .errors import UserError
from .panel import comparison as comparison_panel
from .panel import overlay as overlay_panel
from .panel import render_settings
from .viewport import overlay, redraws, worker


class _Part(Protocol):
    def register(self) -> None: ...
    def unregister(self) -> None: ...


_PARTS: tuple[_Part, ...] = (
    preferences,
    properties,
    comparison_properties,
    engine,
    render_settings,
    comparison_operators,
    comparison_panel,
    compositor,
    overlay,
    overlay_panel,
    blender_command,
)
_registered: list[_Part] = []


def register() -> None:
    """@raises UserError where another copy is on; whatever a part raises, with what was registered before taken back"""
    _refuse_second_copy()
    try:
        for part in _PARTS:
            part.register()
            _registered.append(part)
    except BaseException:
        unregister()
        raise
    # A render engine that is still registered when Python ends hangs Blender's module at exit.
    atexit.register(unregister)


def unregister() -> None:
    atexit.unregister(unregister)
    while _registered:
        _registered.pop().unregister()
    worker.unregister()
    redraws.unregister()
    session.unregister()


def _refuse_second_copy() -> None:
    """Of two copies Blender would silently replace half of one by half of the other."""
    import bpy

    other = bpy.types.RenderEngine.bl_rna_get_subclass_py(engine.ENGINE)
    if other is None or _registered:
        return
    home = str(other.__module__).rsplit(".", 1)[0]
    where = getattr(sys.modules.get(home), "__file__", None) or "unknown place"
    raise UserError(
        f"another copy of Penumbra is switched on: {home} in {Path(where).parent}; switch one of them off "
        "(Preferences > Add-ons, or pip uninstall penumbra) and start Blender again"
    )


def registered() -> bool:
    return bool(_registered)
