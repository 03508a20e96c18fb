"""`penumbra batch`: many scenes and frames. What it does is in the package `batch`; this is what it is asked for."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import errors, interrupts
from ..errors import UserError
from .arguments import comparison_options, frames, machine_arguments, size
from .comparing import options_of
from .registry import command
from .scene import check_exists, check_folder, inside_blender, open_file, say, settings_of

if TYPE_CHECKING:
    from ..batch.jobs import Job, Shot

_DEFAULTS: dict[str, Any] = {
    "render": False, "technique": "", "format": "exr", "device": "", "view_by": "", "workers": 1,
    "no_cache": False, "frames": (), "cameras": (), "size": None, "techniques": (), "set": [], "lights": (),
    "sweep": "off", "timing_seconds": 3.0, "reference_error": 0.002, "target_rmse": None, "warn_rmse": None,
    "fail_rmse": None, "keep_everything": False, "measure_savings": False,
}  # fmt: skip


def _batch_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "inputs", nargs="*" if inside_blender() else "+", type=Path, metavar="JOB.toml | SCENE",
        help="a job file, or scenes: .blend, or a mesh that Blender imports",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results; what is done there is kept")
    parser.add_argument("--frames", type=frames, metavar="A-B[:STEP][,..]", help="default: each file's current one")
    parser.add_argument(
        "--camera", action="append", dest="cameras", metavar="NAME", help="may be repeated; default: the active one"
    )
    parser.add_argument("--name", metavar="NAME", help="what a single scene is called in DIR; default: as its file")
    parser.add_argument("--size", type=size, metavar="WxH", help="picture size in pixels; default: each scene's")
    machine_arguments(parser)
    comparison_options(parser, "off")

    pictures = parser.add_argument_group("pictures instead of comparisons")
    pictures.add_argument("--render", action="store_true", help="render every item with one technique")
    pictures.add_argument("--technique", metavar="ID", help="with --render")
    pictures.add_argument("--format", choices=("exr", "png"), help="with --render; default: exr")

    work = parser.add_argument_group("how the work is done")
    work.add_argument("--workers", type=_count, metavar="N", help="processes on this machine; default: 1")
    work.add_argument("--dask", metavar="ADDRESS", help="workers of a Dask cluster instead, such as tcp://farm:8786")
    work.add_argument(
        "--openjd", type=Path, metavar="FILE", help="do nothing, write an Open Job Description (.json or .yaml)"
    )
    work.add_argument("--dry-run", action="store_true", help="say what there is to do, and do nothing")
    again = work.add_mutually_exclusive_group()
    again.add_argument("--overwrite", action="store_true", help="do everything anew, also what has not changed")
    again.add_argument("--keep-existing", action="store_true", help="keep every result, also what has changed")
    summing = work.add_mutually_exclusive_group()
    summing.add_argument("--no-summary", action="store_true", help="do the items and write no summary")
    summing.add_argument("--summary-only", action="store_true", help="do no item, sum up what there is")
    work.add_argument(
        "--items-per-worker", type=_count, default=50, metavar="N", help="then a fresh process; default: 50"
    )
    work.add_argument(
        "--item-timeout", type=_seconds, metavar="S", help="an item that takes longer counts as crashed; default: none"
    )
    # None tells what was not given from what was: a job file stands between.
    parser.set_defaults(**dict.fromkeys(_DEFAULTS))


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 100_000:
        raise argparse.ArgumentTypeError(f'"{text}" is not a whole number from 1 on')
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f'"{text}" is not a number of seconds above 0')
    return value


@command("batch", "compare or render many scenes and frames, resumable, with one summary", _batch_arguments)
def _batch(arguments: argparse.Namespace) -> int:
    with interrupts.held():
        from .. import doctor, native
        from ..batch import run
        from ..files import why_not_writable

    core = native.load()
    job = job_of(core, arguments)
    for shot in job.shots:
        check_exists(shot.scene)
    native.view_by(job.view_by)  # a wrong PENUMBRA_VIEW_BY would fail every item
    missing = doctor.missing_libraries()
    if missing:
        raise UserError(f"the report needs more Python packages; run: pip install {' '.join(missing)}")
    if arguments.openjd is not None:
        from ..batch import openjd

        missing_values = openjd.write(job, arguments.openjd)
        print(arguments.openjd)
        for name, value in missing_values.items():  # outside the file's folder, which a default may not be
            print(f"give when submitting: {name}={value}")
        return errors.OK
    check_folder(job.out, why_not_writable(job.out))
    return run.run(
        job,
        run.How(
            dask=arguments.dask,
            dry_run=arguments.dry_run,
            overwrite=arguments.overwrite,
            keep_existing=arguments.keep_existing,
            do_items=not arguments.summary_only,
            summary=not arguments.no_summary,
            items_per_worker=arguments.items_per_worker,
            timeout_s=arguments.item_timeout,
            given=arguments.given,
        ),
        say,
    )


def job_of(core: Any, arguments: argparse.Namespace) -> Job:
    """What is wanted, from defaults, job file and command line. @raises UserError"""
    from ..batch import jobfile, jobs

    inputs: list[Path] = arguments.inputs or [Path(open_file())]
    files = [path for path in inputs if path.suffix.lower() == ".toml"]
    if files and len(inputs) > 1:
        raise UserError("give one job file, or scenes; a job file names its scenes itself")
    common: jobfile.Wishes = {}
    scenes: list[jobfile.Wishes] = [{"path": path} for path in inputs]
    if files:
        common, scenes = jobfile.read(files[0])
    if arguments.name is not None:
        if len(scenes) > 1:
            raise UserError("--name is for a single scene; in a job file each scene has a name of its own")
        scenes[0]["name"] = arguments.name
    given = {name: value for name in _DEFAULTS if (value := getattr(arguments, name)) is not None}
    whole = _layered(common, given)
    out = arguments.out or common.get("out")
    if out is None:
        raise UserError(
            "say with --out where the results go" + (', or with out = "DIR" in the job file' if files else "")
        )
    _check_mode(whole)
    names = jobs.named((scene.get("name"), scene["path"]) for scene in scenes)
    shots = []
    for name, scene in zip(names, scenes, strict=True):
        wishes = _layered(_for_scene(common, scene), scene, given)
        shots.append(_shot(core, name, scene["path"], wishes))
    return jobs.Job(
        shots=tuple(shots),
        out=out,
        mode="render" if whole["render"] else "compare",
        technique=whole["technique"] if whole["render"] else "",
        format=whole["format"],
        device=whole["device"],
        view_by=whole["view_by"],
        workers=whole["workers"],
    )


def _layered(*layers: dict[str, Any]) -> dict[str, Any]:
    """The last layer that says anything wins, key by key; settings add up."""
    merged = dict(_DEFAULTS)
    for layer in layers:
        merged |= layer | {"set": [*merged["set"], *layer.get("set", [])]}
    return merged


def _for_scene(common: dict[str, Any], scene: dict[str, Any]) -> dict[str, Any]:
    """What holds for all, without the settings of techniques that this scene leaves out."""
    kept = scene.get("techniques")
    if not kept:
        return common
    return common | {"set": [text for text in common.get("set", []) if text.partition(".")[0] in kept]}


def _check_mode(whole: dict[str, Any]) -> None:
    if whole["render"] and not whole["technique"]:
        raise UserError("say with --technique what to render with (see `penumbra techniques`)")
    if whole["technique"] and not whole["render"]:
        raise UserError("--technique is for --render; a comparison takes --techniques")
    for name in ("warn_rmse", "fail_rmse", "target_rmse"):
        if whole["render"] and whole[name] is not None:
            raise UserError(f"--{name.replace('_', '-')} is for comparisons; --render measures no errors")


def _shot(core: Any, name: str, path: Path, wishes: dict[str, Any]) -> Shot:
    from .. import compare
    from ..batch.jobs import Shot

    if wishes["render"]:
        technique = wishes["technique"]
        settings = {technique: settings_of(core, technique, wishes["set"])}
        options = compare.Options(
            settings=settings, lights=tuple(wishes["lights"]), keep_everything=wishes["keep_everything"]
        )
    else:
        options = options_of(core, argparse.Namespace(**wishes))
    return Shot(
        name=name,
        scene=path,
        frames=tuple(wishes["frames"]),
        cameras=tuple(wishes["cameras"]),
        size=wishes["size"],
        options=options,
        warn_rmse=wishes["warn_rmse"],
        fail_rmse=wishes["fail_rmse"],
    )


def _worker_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--channel", type=int, required=True, metavar="FD", help="the pipe to its parent")


@command("batch-worker", "", _worker_arguments)
def _worker(arguments: argparse.Namespace) -> int:
    from ..batch import worker

    return worker.serve(arguments.channel)
