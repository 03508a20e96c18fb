"""Loads the compiled core, and says in one sentence why it cannot be loaded."""

from __future__ import annotations

import functools
import sys
from typing import Any

from .errors import UserError


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
