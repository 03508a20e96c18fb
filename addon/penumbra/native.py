"""Loads the compiled core and makes its renderers, and says in one sentence why it cannot be loaded."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
from pathlib import Path
from typing import Any

from .errors import UserError, sentence_of, unknown
from .read.errors import BridgeError

VIEWS = ("raster", "rays")
"""What finds the triangle that each pixel shows: OpenGL, which draws it, or camera rays."""


@functools.cache
def load() -> Any:
    """The module penumbra_core.

    @raises UserError with the loader's own words if it is missing or does not fit this Python.
    """
    try:
        import penumbra_core
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:2]))
        raise UserError(
            f"the compiled module penumbra_core cannot be loaded in Python {version} ({error}); "
            "install it with: pip install penumbra"
        ) from error
    return penumbra_core


def view_by(asked: str = "") -> str:
    """One of VIEWS: what is asked for, else what PENUMBRA_VIEW_BY says, else the first.

    @raises UserError for any other word
    """
    for what, word in (("view", asked), ("PENUMBRA_VIEW_BY", os.environ.get("PENUMBRA_VIEW_BY", ""))):
        if word and word not in VIEWS:
            raise unknown(what, word, VIEWS)
        if word:
            return word
    return VIEWS[0]


def renderer(core: Any, device: str = "", view: str = "", **options: Any) -> Any:
    """All of this package's renderers come from here. @param view see view_by()

    @raises UserError for an unknown view, core.DeviceError without a usable device
    """
    return core.Renderer(device, view_by=view_by(view), **options)


@functools.cache
def fingerprint() -> str:
    """Tells one build of the core from another: version, and size and time of the compiled files."""
    core = load()
    folder = Path(core.__file__).parent
    files = sorted(folder.glob("*.so")) if folder.name == "penumbra_core" else [Path(core.__file__)]
    facts = [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files]
    return f"{core.__version__} {facts}"


def sentence(error: BaseException) -> str:
    """What Blender's user is told: of errors that speak to users their sentence; of anything unforeseen the kind as
    well, for a report of a bug.
    """
    known: tuple[type[BaseException], ...] = (UserError, BridgeError)
    with contextlib.suppress(UserError):
        known = (*known, load().Error)
    told = sentence_of(error)
    return told if isinstance(error, known) else f"{type(error).__name__}: {told}"
