"""Job files: a batch written down as TOML. docs/batch.md has an example with every key."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..commands import arguments as types
from ..errors import UserError, unknown
from ..native import VIEWS

Wishes = dict[str, Any]
"""What one layer asks for, by the names of the options. Later layers win: defaults, file, scene, command line."""


def _text(value: Any) -> Any:
    if not isinstance(value, str) or not value:
        raise argparse.ArgumentTypeError("give a text")
    return value


def _choice(*choices: str) -> Callable[[Any], Any]:
    def read(value: Any) -> Any:
        if value not in choices:
            raise argparse.ArgumentTypeError(f"give one of {', '.join(choices)}")
        return value

    return read


def _flag(value: Any) -> Any:
    if not isinstance(value, bool):
        raise argparse.ArgumentTypeError("give true or false")
    return value


def _whole(low: int, high: int) -> Callable[[Any], Any]:
    def read(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise argparse.ArgumentTypeError(f"give a whole number from {low} to {high}")
        return value

    return read


def _number(low: float, high: float) -> Callable[[Any], Any]:
    between = types.between(low, high)
    return lambda value: between("" if isinstance(value, bool) else str(value))


def _names(value: Any) -> Any:
    names = value.split(",") if isinstance(value, str) else value
    if not isinstance(names, list) or not names or not all(isinstance(name, str) and name.strip() for name in names):
        raise argparse.ArgumentTypeError('give "all" or a list of names')
    return types.names(",".join(names))


def _cameras(value: Any) -> Any:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
        raise argparse.ArgumentTypeError("give a name or a list of names")
    return tuple(names)


def _frames(value: Any) -> Any:
    parts = value if isinstance(value, list) else [value]
    if not parts or not all(isinstance(part, (int, str)) and not isinstance(part, bool) for part in parts):
        raise argparse.ArgumentTypeError('give frames as "1-10", as a number, or as a list of these')
    return types.frames(",".join(map(str, parts)))


def _size(value: Any) -> Any:
    if isinstance(value, list) and len(value) == 2:
        value = "x".join(map(str, value))
    return types.size(str(value))


def _settings(value: Any) -> Any:
    if not isinstance(value, dict) or not all(isinstance(settings, dict) for settings in value.values()):
        raise argparse.ArgumentTypeError("give a table per technique, such as [settings.pcf]")
    texts = []
    for technique, settings in value.items():
        for key, given in settings.items():
            word = ("on" if given else "off") if isinstance(given, bool) else str(given)
            texts.append(f"{technique}.{key}={word}")
    return texts


Readers = dict[str, Callable[[Any], Any]]

# What a scene may ask for by itself; the same keys at the top of the file hold for all scenes.
_OF_SCENE: Readers = {
    "frames": _frames,
    "cameras": _cameras,
    "size": _size,
    "techniques": _names,
    "settings": _settings,
    "lights": _names,
    "sweep": _choice("off", "quick", "full"),
    "reference_error": _number(1e-5, 0.5),
    "target_rmse": _number(0.0, 1.0),
    "timing_seconds": _number(0.01, 3600.0),
    "warn_rmse": _number(0.0, 1.0),
    "fail_rmse": _number(0.0, 1.0),
    "keep_everything": _flag,
    "measure_savings": _flag,
}
_OF_JOB: Readers = {
    "out": _text,
    "mode": _choice("compare", "render"),
    "technique": _text,
    "format": _choice("exr", "png"),
    "device": _text,
    "view_by": _choice(*VIEWS),
    "workers": _whole(1, 256),
    "no_cache": _flag,
}
# The option that a key is, where the names differ.
_OPTIONS = {"settings": "set", "mode": "render"}


def read(path: Path) -> tuple[Wishes, list[Wishes]]:
    """(what holds for all, what each scene asks for with its "path" and "name"); paths are relative to the file.

    @raises UserError with the file, the key and what to write instead
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f'the job file "{path}" cannot be read: {(error.strerror or str(error)).lower()}') from error
    except (ValueError, RecursionError) as error:  # besides tomllib's own: numbers too long, lists too deep
        raise UserError(f'the job file "{path}" is not TOML: {error}') from error
    scenes = document.pop("scenes", None)
    common = _read_table(path, "the job file", document, _OF_SCENE | _OF_JOB)
    if "out" in common:
        common["out"] = path.parent / common["out"]
    if not isinstance(scenes, list) or not scenes or not all(isinstance(entry, dict) for entry in scenes):
        raise UserError(f'the job file "{path}" has no scenes; write [[scenes]] and path = "shot.blend" for each')
    wanted = []
    for number, entry in enumerate(scenes, 1):
        where = f"scene {number}"
        wishes = _read_table(path, where, entry, _OF_SCENE | {"path": _text, "name": _text})
        if "path" not in wishes:
            raise UserError(f'{where} of the job file "{path}" has no path')
        wishes["path"] = path.parent / wishes["path"]
        wanted.append(wishes)
    return common, wanted


def _read_table(path: Path, where: str, table: dict[str, Any], readers: Readers) -> Wishes:
    wishes: Wishes = {}
    for key, value in table.items():
        if key not in readers:
            choices = [*readers, "scenes"] if where == "the job file" else list(readers)
            raise UserError(f"{path}: {unknown(f'key of {where}', key, choices)}")
        try:
            wishes[_OPTIONS.get(key, key)] = readers[key](value)
        except argparse.ArgumentTypeError as error:
            raise UserError(f'{path}: "{key}" of {where}: {error}') from error
    if "render" in wishes:
        wishes["render"] = wishes["render"] == "render"
    return wishes
