"""`blender -b shot.blend --command penumbra ...`: the command line inside Blender, which is that of `penumbra`."""

from __future__ import annotations

from typing import Any

NAME = "penumbra"

_handles: list[Any] = []


def register() -> None:
    import bpy

    _handles.append(bpy.utils.register_cli_command(NAME, _execute))


def unregister() -> None:
    import bpy

    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())


def _execute(arguments: list[str]) -> int:
    """Blender hands over what stands after the name, and ends with the code that it gets."""
    from . import cli

    return cli.main(arguments)
