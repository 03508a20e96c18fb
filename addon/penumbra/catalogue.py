"""The techniques and their settings as a file, so that Blender's panels stand without the compiled core.

The core is loaded at the first picture, not when the add-on is switched on. `tools/make_stubs` writes the file from the
core, and a test holds it to the core.
"""

from __future__ import annotations

import functools
import json
from importlib import resources
from typing import Any

FILE = "techniques.json"


@functools.cache
def techniques() -> tuple[dict[str, Any], ...]:
    """What `penumbra_core.techniques()` tells, in the order users see."""
    text = resources.files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return tuple(json.loads(text))


def technique(identifier: str) -> dict[str, Any]:
    """@raises KeyError for a technique that there is not"""
    for info in techniques():
        if info["id"] == identifier:
            return info
    raise KeyError(identifier)


def written(core: Any) -> str:
    """What the file must hold for this core."""
    return json.dumps(core.techniques(), indent=1, ensure_ascii=False) + "\n"
