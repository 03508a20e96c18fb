"""What every subcommand does with scenes, folders and the machine before its own work begins."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import errors, interrupts, native
from ..errors import UserError


def check_exists(path: Path) -> None:
    if not path.exists():
        raise UserError(f'the scene "{path}" does not exist')


def check_folder(folder: Path, reason: str) -> None:
    if reason:
        raise UserError(f'cannot write to the folder "{folder}": {reason}; choose another one with --out')


def make_renderer(core: Any, device: str, view_by: str) -> Any:
    from ..compare import core_errors

    with core_errors(core), interrupts.held():
        return native.renderer(core, device, view_by)


def read(core: Any, path: Path | None, arguments: argparse.Namespace) -> Any:
    """The scene, seen as the command line asks for. @raises UserError for one that Blender or the core refuses."""
    return read_view(core, path, camera=arguments.camera, size=arguments.size, frame=arguments.frame)


def read_view(
    core: Any, path: Path | None, *, camera: str | None, size: tuple[int, int] | None, frame: int | None
) -> Any:
    """The scene as the core takes it; without a path, the one that is open.

    @raises UserError for a scene that Blender or the core refuses
    """
    from .. import scenes
    from ..compare import core_errors

    try:
        with interrupts.held():
            scenes.import_bpy()
        with core_errors(core), interrupts.deadly():
            if path is not None:
                scenes.open_scene(path)
            return scenes.read(camera=camera, size=size, frame=frame)
    except scenes.SceneError as error:
        raise UserError(errors.sentence_of(error)) from error


def open_file() -> str:
    """The file that Blender has open."""
    return str(sys.modules["bpy"].data.filepath) or "unsaved scene"


def settings_of(core: Any, technique: str, texts: Sequence[str]) -> dict[str, Any]:
    """KEY=VALUE texts as checked settings of one technique. @raises UserError"""
    from .. import compare

    infos = core.techniques()
    compare.choose_techniques(infos, (technique,))
    prefix = f"{technique}."
    parsed = [compare.parse_setting(infos, prefix + text.removeprefix(prefix)) for text in texts]
    return {key: value for _, key, value in parsed}


def inside_blender() -> bool:
    """True in Blender's own program, where a file may be open; False for Blender as a Python module."""
    bpy = sys.modules.get("bpy")
    return bpy is not None and bool(getattr(bpy.app, "binary_path", ""))


def say(sentence: str) -> None:
    print(f"penumbra: {sentence}", file=sys.stderr, flush=True)
