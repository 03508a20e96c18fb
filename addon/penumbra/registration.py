"""Switching the add-on on and off: every part registers itself, and what is registered is taken back in reverse."""

from __future__ import annotations

import atexit
from typing import Protocol

from . import blender_command, compositor, engine, preferences, properties, session
from .comparison import operators as comparison_operators
from .comparison import properties as comparison_properties
from .panel import comparison as comparison_panel
from .panel import overlay as overlay_panel
from .panel import render_settings
from .viewport import overlay, redraws


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
    """@raises whatever a part raises; what was registered before it is taken back"""
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
    redraws.unregister()
    session.unregister()


def registered() -> bool:
    return bool(_registered)
