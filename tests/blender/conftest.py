"""Tests that drive a real Blender (the bpy module). One process serves a whole session; every test starts empty."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))

_MISSING = [name for name in ("bpy", "penumbra_core") if importlib.util.find_spec(name) is None]
if _MISSING:
    collect_ignore_glob = ["test_*.py"]


def pytest_report_header() -> str | None:
    return f"tests/blender left out: {' and '.join(_MISSING)} not installed" if _MISSING else None


@pytest.fixture
def kit() -> Any:
    """An empty scene and short words to fill it."""
    import bpy
    from blender_kit import Kit

    bpy.ops.wm.read_factory_settings(use_empty=True)
    return Kit()


@pytest.fixture
def addon(kit: Any) -> Iterator[Any]:
    """The add-on switched on, and off again afterwards; an empty scene that renders with it, and `kit` to fill it."""
    import penumbra
    from penumbra import registration

    penumbra.register()
    kit.scene.render.engine = "PENUMBRA"
    yield kit
    penumbra.unregister()
    assert not registration.registered()


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> Any:
    """What goes over the border to the core."""
    from blender_kit import record

    return record(monkeypatch)
