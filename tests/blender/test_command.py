"""`blender --command penumbra`, as far as Blender as a module has it: the function that Blender calls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import penumbra
import pytest
from blender_kit import Kit

Registered = dict[str, Callable[[list[str]], int]]


@pytest.fixture
def commands(kit: Kit, monkeypatch: pytest.MonkeyPatch) -> Registered:
    """What is registered by name; the real registration happens too."""
    there: Registered = {}
    register, unregister = bpy.utils.register_cli_command, bpy.utils.unregister_cli_command
    names = {}

    def note(name: str, execute: Callable[[list[str]], int]) -> object:
        handle = register(name, execute)
        there[name] = execute
        names[id(handle)] = name
        return handle

    def forget(handle: object) -> None:
        unregister(handle)
        del there[names.pop(id(handle))]

    monkeypatch.setattr(bpy.utils, "register_cli_command", note)
    monkeypatch.setattr(bpy.utils, "unregister_cli_command", forget)
    return there


def test_the_command_is_there_while_the_add_on_is_on_and_gone_afterwards(commands: Registered) -> None:
    for _ in range(3):
        penumbra.register()
        assert list(commands) == ["penumbra"]
        penumbra.unregister()
        assert commands == {}


def test_the_command_returns_the_exit_code_of_the_command_line(
    commands: Registered, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    penumbra.register()
    try:
        run = commands["penumbra"]
        assert run(["--version"]) == 0
        assert capfd.readouterr().out == f"penumbra {penumbra.__version__}\n"
        assert run(["compare", str(tmp_path / "missing.blend"), "--out", str(tmp_path / "out")]) == 2
        told = capfd.readouterr().err
        assert told.startswith('penumbra: the scene "') and told.endswith('" does not exist\n')
    finally:
        penumbra.unregister()
