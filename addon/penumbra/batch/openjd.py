"""An Open Job Description of a batch: what render-farm managers such as Deadline Cloud take.

One step per scene, one task per frame and camera. A task is `penumbra batch SCENE --frames N ...`, so that it skips
what is done, retries what crashed, and leaves what it makes whole; the last step sums up, and gates with --fail-rmse.
Paths are parameters of the job, which a manager maps to where they lie on its machines. No environments are needed.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from ..errors import UserError
from ..files import slug, write_bytes
from .jobs import Item, Job, expand, frames_text

VERSION = "jobtemplate-2023-09"
SUMMARY = "Summary"
_MAX_NAME = 64
_MAX_RANGE = 1024  # members of a list of values, as the specification allows

Document = dict[str, Any]


def write(job: Job, path: Path) -> dict[str, str]:
    """.json, .yaml or .yml. @return parameters without a default, with the values that they have here

    @raises UserError for another ending, or a job that cannot be written down
    """
    if path.suffix.lower() not in (".json", ".yaml", ".yml"):
        raise UserError(f'an Open Job Description ends in .json or .yaml, not "{path}"')
    if not path.parent.is_dir():
        raise UserError(f'the folder "{path.parent}" for the Open Job Description does not exist')
    # JSON is YAML: one text serves both, and needs no library.
    document = template(job, path.parent)
    write_bytes(path, (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode())
    here = {"Output": job.out.resolve()} | {f"Scene{i}": shot.scene.resolve() for i, shot in enumerate(job.shots, 1)}
    return {
        parameter["name"]: str(here[parameter["name"]])
        for parameter in document["parameterDefinitions"]
        if "default" not in parameter
    }


def template(job: Job, folder: Path) -> Document:
    """The document. folder: where it will lie, which defaults of paths are relative to; they may not lead out of it."""
    items: dict[str, list[Item]] = {}
    for item in expand(job):
        items.setdefault(item.name, []).append(item)
    if SUMMARY in map(_plain, items):
        raise UserError(f"a scene is called {SUMMARY}, as the last step of the job is; name it otherwise")
    parameters: list[Document] = [
        {
            "name": "Penumbra",
            "type": "STRING",
            "default": "penumbra",
            "description": "The program. It has to be on the path of the workers, or to be given with its path.",
        },
        {
            "name": "Output",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "OUT",
            **_default(job.out, folder),
            "description": "The folder for all results; all workers and the summary must see the same one.",
        },
    ]
    steps: list[Document] = []
    for number, (name, own) in enumerate(items.items(), 1):
        scene = f"Scene{number}"
        parameters.append(
            {
                "name": scene,
                "type": "PATH",
                "objectType": "FILE",
                "dataFlow": "IN",
                **_default(Path(own[0].scene), folder),
                "description": f"The scene {name}.",
            }
        )
        steps.append(_step(name, scene, own))
    steps.append(_summary(job, items, [step["name"] for step in steps]))
    if len(parameters) > 50:
        raise UserError(
            f"an Open Job Description has at most 50 parameters, which is 48 scenes; this job has {len(items)}: "
            "write several"
        )
    title = ", ".join(items)
    return {
        "specificationVersion": VERSION,
        "name": f"Penumbra: {_plain(title)}"[:128],
        "parameterDefinitions": parameters,
        "steps": steps,
    }


def _default(path: Path, folder: Path) -> Document:
    try:
        return {"default": path.resolve().relative_to(folder.resolve()).as_posix()}
    except ValueError:
        return {}


def _step(name: str, scene: str, items: list[Item]) -> Document:
    first = items[0]
    arguments = ["batch", f"{{{{Param.{scene}}}}}", "--out", "{{Param.Output}}", "--name", name, "--no-summary"]
    space: list[Document] = []
    if first.frame is not None:
        frames = list(dict.fromkeys(item.frame for item in items if item.frame is not None))
        space.append({"name": "Frame", "type": "INT", "range": frames_text(sorted(frames))})
        arguments.append("--frames={{Task.Param.Frame}}")
    if first.camera is not None:
        cameras = list(dict.fromkeys(item.camera for item in items if item.camera is not None))
        if len(cameras) > _MAX_RANGE:
            raise UserError(f'"{name}" has {len(cameras)} cameras; an Open Job Description takes {_MAX_RANGE}')
        if len({slug(camera) for camera in cameras}) < len(cameras):  # a task does not know the others
            raise UserError(f'cameras of "{name}" differ only in what a file name leaves out; rename one')
        space.append({"name": "Camera", "type": "STRING", "range": [_literal(camera) for camera in cameras]})
        arguments.append("--camera={{Task.Param.Camera}}")
    arguments += [_literal(word) for word in _options(first)]
    step: Document = {"name": _plain(name)[:_MAX_NAME], "script": _script(arguments)}
    if space:
        step["parameterSpace"] = {"taskParameterDefinitions": space}
    return step


def _options(item: Item) -> list[str]:
    words = item.option_arguments()
    return ["--render", f"--format={item.format}", *words] if item.mode == "render" else words


def _summary(job: Job, items: dict[str, list[Item]], steps: list[str]) -> Document:
    """Scenes differ in frames and options, which the summary must know to find their items: so it has a job file."""
    lines = [f"mode = {_toml(job.mode)}"]
    if job.mode == "render":
        lines += [f"technique = {_toml(job.technique)}", f"format = {_toml(job.format)}"]
    if job.device:
        lines.append(f"device = {_toml(job.device)}")
    if job.view_by:
        lines.append(f"view_by = {_toml(job.view_by)}")
    for number, (name, own) in enumerate(items.items(), 1):
        lines += ["", "[[scenes]]", f"path = '''{{{{Param.Scene{number}}}}}'''", f"name = {_toml(name)}"]
        lines += _scene_lines(own)
    return {
        "name": SUMMARY,
        "dependencies": [{"dependsOn": step} for step in steps],
        "script": {
            "embeddedFiles": [
                {"name": "Job", "type": "TEXT", "filename": "job.toml", "data": "\n".join(lines) + "\n"},
            ],
            **_script(["batch", "{{Task.File.Job}}", "--out", "{{Param.Output}}", "--summary-only"]),
        },
    }


def _scene_lines(items: list[Item]) -> list[str]:
    first = items[0]
    options = first.options
    found: dict[str, Any] = {}
    if first.frame is not None:
        found["frames"] = frames_text(dict.fromkeys(item.frame for item in items if item.frame is not None))
    if first.camera is not None:
        found["cameras"] = list(dict.fromkeys(item.camera for item in items if item.camera is not None))
    found |= {"size": list(first.size)} if first.size else {}
    found |= {"lights": list(options.lights)} if options.lights else {}
    found["keep_everything"] = options.keep_everything
    if first.mode == "compare":
        found |= {
            "techniques": list(options.techniques),
            "sweep": options.sweep,
            "reference_error": options.reference_error,
            "target_rmse": options.target_rmse,
            "timing_seconds": options.timing_seconds,
            "measure_savings": options.measure_savings,
            # A step that ends with any other code than 0 has failed; a warning is for the summary's page.
            "fail_rmse": first.fail_rmse,
        }
    lines = [f"{key} = {_toml(value)}" for key, value in found.items() if value is not None]
    for technique, settings in options.settings.items():
        if settings:
            lines += [f"[scenes.settings.{technique}]", *(f"{key} = {_toml(value)}" for key, value in settings.items())]
    return lines


def _script(arguments: list[str]) -> Document:
    return {"actions": {"onRun": {"command": "{{Param.Penumbra}}", "args": arguments}}}


def _toml(value: Any) -> str:
    """Of our plain values, JSON's way to write one is TOML's."""
    return _literal(json.dumps(value, ensure_ascii=False)) if not isinstance(value, float) else repr(value)


def _literal(text: str) -> str:
    """@raises UserError for what the description would take for one of its own expressions"""
    if "{{" in text:
        raise UserError(f'"{text}" holds "{{{{", which has a meaning in an Open Job Description; rename it')
    return text


def _plain(text: str) -> str:
    return re.sub(r"[\x00-\x1f\x7f-\x9f]+", " ", text).strip() or "unnamed"
