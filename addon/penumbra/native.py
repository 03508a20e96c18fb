"""Loads the compiled core, and says in one sentence why it cannot be loaded."""

from __future__ import annotations

import contextlib
import functools
import sys
from pathlib import Path
from typing import Any

from .errors import UserError, sentence_of
from .read.errors import BridgeError


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
