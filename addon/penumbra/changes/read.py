"""report.json, checked so far that nothing behind this border meets a number that is none."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ..errors import UserError
from ..records import SCHEMA, Comparison, LightResult, Record, Spread, from_json


@dataclass(frozen=True)
class Report:
    path: Path
    comparison: Comparison

    @property
    def environment(self) -> dict[str, Any]:
        return self.comparison.environment


def read(path: Path) -> Report:
    """@param path a report.json, or the folder it lies in. @raises UserError with one sentence"""
    file = path / "report.json" if path.is_dir() else path

    def refuse(word: str) -> NoReturn:
        raise UserError(f'"{file}" holds {word}, which is no number here: it is not a report.json that Penumbra wrote')

    def number(digits: str) -> float:
        value = float(digits)
        return value if math.isfinite(value) else refuse(digits)  # 1e999

    try:
        document = json.loads(file.read_text(encoding="utf-8"), parse_constant=refuse, parse_float=number)
    except FileNotFoundError:
        missing = "has no report.json" if path.is_dir() else "does not exist"
        raise UserError(f'"{path}" {missing}; give a report.json or the folder of a report') from None
    except OSError as error:
        raise UserError(f'"{file}" cannot be read: {(error.strerror or str(error)).lower()}') from error
    except (ValueError, RecursionError) as error:
        raise UserError(f'"{file}" is not JSON: {str(error).splitlines()[0]}') from error
    if not isinstance(document, dict) or "schema" not in document or "scenes" not in document:
        raise UserError(f'"{file}" is not a report.json of Penumbra: it lacks "schema" or "scenes"')
    if document["schema"] != SCHEMA or isinstance(document["schema"], bool):
        raise UserError(f'"{file}" has schema {document["schema"]!r}; this version of Penumbra reads schema {SCHEMA}')
    try:
        comparison = from_json(document)
        _check(comparison)
    except _DamagedError as error:
        raise UserError(f'"{file}" is damaged: {error}') from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else str(error).splitlines()[0]
        raise UserError(f'"{file}" is damaged: {what}') from error
    return Report(file, comparison)


class _DamagedError(Exception):
    """What is wrong, and where."""


def _check(comparison: Comparison) -> None:
    _want(comparison.environment, dict, "the environment")
    _want(comparison.options, dict, "the options")
    for scene in comparison.scenes:
        _want(scene.path, str, "a scene's path")
        where = f'the scene "{scene.path}"'
        _want(scene.camera, str, f"the camera of {where}")
        for value, what in ((scene.frame, "frame"), (scene.triangles, "number of triangles")):
            _number(value, f"the {what} of {where}")
        for light in scene.lights:
            _check_light(light, where)


def _check_light(light: LightResult, where: str) -> None:
    _want(light.name, str, f"a light's name in {where}")
    _want(light.reference_info, dict, f'the reference at "{light.name}" in {where}')
    for record in light.records:
        for value, what in ((record.technique, "technique"), (record.title, "title"), (record.status, "status")):
            _want(value, str, f'the {what} of a record at "{light.name}" in {where}')
        _check_record(record, f'{record.technique} at "{light.name}" in {where}')


def _check_record(record: Record, who: str) -> None:
    _want(record.settings, dict, f"the settings of {who}")
    _want(record.reason, str, f"the reason of {who}")
    if record.sweep is not None:
        _want(record.sweep, dict, f"the sweep of {who}")
        _want(record.changed, dict, f"what the sweep of {who} changes")
    for name, value in (record.settings | record.changed).items():
        if (isinstance(value, float) and not math.isfinite(value)) or not isinstance(value, (bool, int, float, str)):
            raise _DamagedError(f"the setting {name} of {who} is {value!r}")
    if record.status != "ok":
        return
    _want(record.area, dict, f"the errors of {who}")
    _number(record.headline, f"the headline error of {who}", most=1.0)
    _number(record.headline_error, f"the standard error of {who}")
    _number((record.area or {}).get("reference_standard_error", 0.0), f"the reference's standard error of {who}")
    _number(record.memory_bytes, f"the memory of {who}")
    for name, spread in record.time_ms.items():
        _check_time(spread, f"the {name} time of {who}")
    for step in record.plan:
        for value in (step.step, step.state, step.reason, step.rule):
            _want(value, str, f"a step in the plan of {who}")


def _check_time(spread: Spread, what: str) -> None:
    for value in (spread.median, spread.low, spread.high, spread.runs):
        _number(value, what)
    if not spread.low <= spread.median <= spread.high:
        raise _DamagedError(f"{what} has a median of {spread.median:g} ms outside its interval")


def _want(value: Any, kind: type, what: str) -> None:
    if not isinstance(value, kind):
        raise _DamagedError(f"{what} is {value!r}")


def _number(value: Any, what: str, most: float = math.inf) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _DamagedError(f"{what} is {value!r}, not a number")
    if not math.isfinite(value) or abs(value) > 1e300 or value > most:
        raise _DamagedError(f"{what} is {value!r}")
    if value < 0 and not what.startswith("the frame"):
        raise _DamagedError(f"{what} is {value!r}")
