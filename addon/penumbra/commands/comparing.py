"""`penumbra compare` and `penumbra demo`."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import Any

from .. import errors, interrupts
from ..errors import UserError
from .arguments import compare_options
from .registry import command
from .scene import check_exists, check_folder, inside_blender, make_renderer, open_file, read, say


def _compare_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenes", nargs="*" if inside_blender() else "+", type=Path, metavar="SCENE",
        help=".blend, or a mesh that Blender imports (.obj .ply .stl .glb .gltf .usd*)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the report")
    compare_options(parser, "off")


@command("compare", "compare techniques with the truth on scenes, and write a report", _compare_arguments)
def _compare(arguments: argparse.Namespace) -> int:
    return _run_comparison(arguments, arguments.scenes)


def _demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, default=Path("penumbra-demo"), metavar="DIR", help="default: penumbra-demo")
    compare_options(parser, "quick")


@command("demo", "compare all techniques on the bundled scene", _demo_arguments)
def _demo(arguments: argparse.Namespace) -> int:
    return _run_comparison(arguments, [bundled_scene("courtyard")])


def bundled_scene(name: str) -> Path:
    """A scene that comes with Penumbra. @raises UserError if it is not there."""
    package = Path(__file__).resolve().parents[1]
    places = [
        package / "examples",
        package.parents[1] / "examples",
        Path(sys.prefix) / "share" / "penumbra" / "examples",
    ]
    for place in places:
        if (place / f"{name}.blend").is_file():
            return place / f"{name}.blend"
    raise UserError(f"the bundled scene {name}.blend is missing; looked in {', '.join(map(str, places))}")


def _run_comparison(arguments: argparse.Namespace, paths: list[Path]) -> int:
    with interrupts.held():
        from .. import compare, doctor, environment, native, together
        from ..files import why_not_writable
        from ..progress import Progress
        from ..records import Comparison, Failure
        from ..report import ReportWriter

    # Everything that can be known to be wrong is found before Blender is loaded and anything is made.
    for path in paths:
        check_exists(path)
    check_folder(arguments.out, why_not_writable(arguments.out))
    missing = doctor.missing_libraries()
    if missing:
        raise UserError(f"the report needs more Python packages; run: pip install {' '.join(missing)}")
    core = native.load()
    options = options_of(core, arguments)
    renderer = make_renderer(core, arguments.device, arguments.view_by)
    comparison = Comparison(environment={}, options=_recorded_options(arguments))
    writer = ReportWriter(arguments.out)
    with Progress() as progress:
        comparer = compare.Comparer(core, renderer, options, progress)
        refusals: list[UserError] = []
        wanted: list[Path | None] = [*paths] or [None]  # none: the file that Blender has open
        for source in wanted:
            progress.stage(f"{Path(source or open_file()).stem}: reading", 0.0)
            try:
                export = read(core, source, arguments)
                progress.add_work(comparer.work(len(options.lights) or len(export.lights)))
                with compare.core_errors(core):
                    scene = comparer.compare(export, str(source or open_file()))
            except UserError as error:
                refusals.append(error)
                comparison.failures.append(Failure(str(source), str(error)))
                continue
            writer.add_scene(scene)
            comparison.scenes.append(scene)
        if not comparison.scenes:
            raise refusals[0]
        progress.stage("report", 1.0)
        comparison.failures += comparer.failures
        together.summarise(comparison, options.target_rmse)
        comparison.environment = environment.collect(core, renderer, arguments.given)
        page = writer.finish(comparison)
        progress.finish()
    return _conclude(comparison, page, arguments)


def _recorded_options(arguments: argparse.Namespace) -> dict[str, Any]:
    names = (
        "sweep", "reference_error", "target_rmse", "timing_seconds", "warn_rmse", "fail_rmse", "keep_everything",
        "measure_savings",
    )  # fmt: skip
    return {name: getattr(arguments, name) for name in names}


def options_of(core: Any, arguments: argparse.Namespace) -> Any:
    from .. import compare

    infos = core.techniques()
    chosen = [str(info["id"]) for info in compare.choose_techniques(infos, arguments.techniques)]
    settings: dict[str, dict[str, Any]] = {}
    for text in arguments.set:
        technique, key, value = compare.parse_setting(infos, text)
        if technique not in chosen:
            raise UserError(f"--set {text} is for a technique that is not compared; add {technique} to --techniques")
        settings.setdefault(technique, {})[key] = value
    return compare.Options(
        techniques=tuple(chosen),
        settings=settings,
        lights=arguments.lights,
        sweep=arguments.sweep,
        reference_error=arguments.reference_error,
        target_rmse=arguments.target_rmse,
        keep_everything=arguments.keep_everything,
        use_cache=not arguments.no_cache,
        timing_seconds=arguments.timing_seconds,
        measure_savings=arguments.measure_savings,
    )


def _tell(light: Any) -> None:
    for sentence in light.sentences:
        print(f"  {sentence}")
    if light.pick is not None:
        print(f"  use: {shlex.join(light.pick.arguments)}")


def _conclude(comparison: Any, page: Path, arguments: argparse.Namespace) -> int:
    """Prints what came out, and returns the exit code."""
    from .. import verdict

    for scene in comparison.scenes:
        for light in scene.lights:
            print(f"{scene.name}, {light.name} ({light.shape})")
            for record in light.records:
                if record.is_sweep_step:
                    continue
                if record.status == "ok":
                    dynamic = record.time_ms["dynamic"].median
                    mark = "front" if record.on_pareto_front else ""
                    print(f"  {record.technique:<20} {record.headline:>9.4f}  {dynamic:>9.2f} ms  {mark}".rstrip())
                else:
                    print(f"  {record.technique:<20} {record.status}: {record.reason}")
            _tell(light)
            count, tight = verdict.medians(light)
            if tight < count:
                print(f"  {verdict.timing_sentence(light)}")
        if scene.together is not None:
            print(scene.together.name)
            _tell(scene.together)
    if comparison.together is not None:
        print(f"{comparison.together.name} ({len(comparison.scenes)}; times are geometric means)")
        _tell(comparison.together)
    print(f"report: {page}")
    worst = max(
        (
            (record.headline, f"{record.technique} at {light.name} in {scene.name}")
            for scene in comparison.scenes
            for light in scene.lights
            for record in light.records
            if record.status == "ok" and not record.is_sweep_step
        ),
        default=(0.0, ""),
    )
    for failure in comparison.failures:
        say(f"{failure.what}: {failure.reason}")
    if comparison.failures:
        return errors.FAILED
    for limit, code, name in (
        (arguments.fail_rmse, errors.FAIL, "--fail-rmse"),
        (arguments.warn_rmse, errors.WARN, "--warn-rmse"),
    ):
        if limit is not None and worst[0] > limit:
            say(f"{worst[1]} has a penumbra RMSE of {worst[0]:.4g}, above {name} {limit:g}")
            return code
    return errors.OK
