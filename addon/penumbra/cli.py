"""The command line: one program, inside Blender (`blender -b shot.blend --command penumbra ...`) and out.

A subcommand is one function decorated with @command; its parser lies beside it. Exit codes: 0 all was done; 1 something
failed on the way; 2 bad usage or bad input, nothing written; 3 and 4 an error is above --warn-rmse / --fail-rmse;
130 interrupted (by the signal itself while a scene is read, which a shell tells as 130 too).
"""

from __future__ import annotations

import argparse
import difflib
import json
import math
import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from . import __version__, errors, interrupts
from .errors import UserError

Run = Callable[[argparse.Namespace], int]


@dataclass(frozen=True)
class _Command:
    name: str
    summary: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Run


_COMMANDS: list[_Command] = []


def command(name: str, summary: str, add_arguments: Callable[[argparse.ArgumentParser], None]) -> Callable[[Run], Run]:
    """Makes the function a subcommand. It gets the parsed arguments and returns an exit code."""

    def register(run: Run) -> Run:
        _COMMANDS.append(_Command(name, summary, add_arguments, run))
        return run

    return register


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, without the usage text."""

    def error(self, message: str) -> NoReturn:
        match = re.match(r"argument (\S+): invalid choice: '?(.*?)'? \(choose from (.*)\)", message)
        if match:
            names = [name.strip(" '") for name in match[3].split(",")]
            close = difflib.get_close_matches(match[2], names, n=1, cutoff=0.6)
            hint = f"did you mean {close[0]}? " if close else ""
            what = "command" if match[1] == "COMMAND" else f"value of {match[1]}"
            message = f'unknown {what} "{match[2]}"; {hint}choose from: {", ".join(names)}'
        elif message.startswith("unrecognized arguments: "):
            message = self._unrecognised(message.removeprefix("unrecognized arguments: "))
        raise UserError(f"{message} (see {self.prog} --help)")

    def _unrecognised(self, text: str) -> str:
        given = text.split()[0]
        options = [option for action in self._actions for option in action.option_strings]
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                parsers = action.choices.values()
                options += [
                    option for parser in parsers for inner in parser._actions for option in inner.option_strings
                ]
        close = difflib.get_close_matches(given.split("=")[0], options, n=1, cutoff=0.6)
        return f'unknown option "{given}"' + (f", did you mean {close[0]}?" if close else "")


def _parser() -> _Parser:
    parser = _Parser(
        prog="penumbra",
        description="Renders classic soft-shadow techniques on a Blender scene and reports error against time.",
        epilog="Exit codes: 0 done; 1 something failed on the way; 2 bad usage or input; 3 and 4 an error is above "
        "--warn-rmse / --fail-rmse; 130 interrupted.",
    )
    parser.add_argument("--version", action="version", version=f"penumbra {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", dest="command", required=True, parser_class=_Parser)
    for entry in _COMMANDS:
        sub = commands.add_parser(
            entry.name, help=entry.summary, description=entry.summary[:1].upper() + entry.summary[1:] + "."
        )
        entry.add_arguments(sub)
        sub.set_defaults(run=entry.run)
    return parser


# --- argument types --------------------------------------------------------------------------------------------------


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)[xX×](\d+)", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if not all(1 <= side <= 16384 for side in size):
        raise argparse.ArgumentTypeError(f'"{text}" is not a size such as 640x360, each side from 1 to 16384')
    return size


def _names(text: str) -> tuple[str, ...]:
    """ "all" is the empty tuple."""
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise argparse.ArgumentTypeError('give "all" or names separated by commas')
    return () if names == ("all",) else names


def _between(low: float, high: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f'"{text}" is not a number from {low:g} to {high:g}')
        return value

    return parse


_error = _between(0.0, 1.0)


def _frame(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 1 << 30
    if abs(value) > 1048574:  # Blender's own limit
        raise argparse.ArgumentTypeError(f'"{text}" is not a frame number')
    return value


def _view_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--camera", metavar="NAME", help="camera object; default: the scene's active one")
    parser.add_argument("--frame", type=_frame, metavar="N", help="frame; default: the file's current one")
    parser.add_argument("--size", type=_size, metavar="WxH", help="picture size in pixels; default: the scene's")
    parser.add_argument("--device", default="", metavar="D", help="EGL device: its number or a part of its name")


def _compare_options(parser: argparse.ArgumentParser, sweep: str) -> None:
    parser.add_argument(
        "--techniques", type=_names, default=(), metavar="all|ID,ID", help="see `penumbra techniques`; default: all"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="TECHNIQUE.KEY=VALUE", help="a setting; may be repeated"
    )
    parser.add_argument("--lights", type=_names, default=(), metavar="all|NAME,..", help="default: all")
    _view_arguments(parser)
    parser.add_argument(
        "--sweep", choices=("off", "quick", "full"), default=sweep,
        help=f"vary the quality settings, which gives the error-versus-time curves; default: {sweep}",
    )  # fmt: skip
    parser.add_argument(
        "--reference-error", type=_between(1e-5, 0.5), default=0.002, metavar="E",
        help="standard error of the reference, per pixel, of V; default: 0.002",
    )  # fmt: skip
    parser.add_argument("--target-rmse", type=_error, metavar="E", help="name the cheapest technique within this error")
    parser.add_argument("--warn-rmse", type=_error, metavar="E", help="exit code 3 if a penumbra RMSE is above")
    parser.add_argument("--fail-rmse", type=_error, metavar="E", help="exit code 4 if a penumbra RMSE is above")
    parser.add_argument("--keep-everything", action="store_true", help="leave no work out")
    parser.add_argument("--no-cache", action="store_true", help="trace the references anew and keep none")


# --- compare and demo ------------------------------------------------------------------------------------------------


def _compare_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenes", nargs="*" if _inside_blender() else "+", type=Path, metavar="SCENE",
        help=".blend, or a mesh that Blender imports (.obj .ply .stl .glb .gltf .usd*)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the report")
    _compare_options(parser, "off")


@command("compare", "compare techniques with the truth on scenes, and write a report", _compare_arguments)
def _compare(arguments: argparse.Namespace) -> int:
    return _run_comparison(arguments, arguments.scenes)


def _demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, default=Path("penumbra-demo"), metavar="DIR", help="default: penumbra-demo")
    _compare_options(parser, "quick")


@command("demo", "compare all techniques on the bundled scene", _demo_arguments)
def _demo(arguments: argparse.Namespace) -> int:
    return _run_comparison(arguments, [bundled_scene("courtyard")])


def bundled_scene(name: str) -> Path:
    """A scene that comes with Penumbra. @raises UserError if it is not there."""
    package = Path(__file__).resolve().parent
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
        from . import compare, doctor, environment, native
        from .files import why_not_writable
        from .progress import Progress
        from .records import Comparison, Failure
        from .report import ReportWriter

    # Everything that can be known to be wrong is found before Blender is loaded and anything is made.
    for path in paths:
        _check_exists(path)
    _check_folder(arguments.out, why_not_writable(arguments.out))
    missing = doctor.missing_libraries()
    if missing:
        raise UserError(f"the report needs more Python packages; run: pip install {' '.join(missing)}")
    core = native.load()
    options = _options(core, arguments)
    renderer = _renderer(core, arguments.device)
    comparison = Comparison(environment={}, options=_recorded_options(arguments))
    writer = ReportWriter(arguments.out)
    with Progress() as progress:
        comparer = compare.Comparer(core, renderer, options, progress)
        refusals: list[UserError] = []
        wanted: list[Path | None] = [*paths] or [None]  # none: the file that Blender has open
        for source in wanted:
            progress.stage(f"{Path(source or _open_file()).stem}: reading", 0.0)
            try:
                export = _read(core, source, arguments)
                progress.add_work(comparer.work(len(options.lights) or len(export.lights)))
                with compare.core_errors(core):
                    scene = comparer.compare(export, str(source or _open_file()))
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
        comparison.environment = environment.collect(core, renderer, arguments.given)
        page = writer.finish(comparison)
        progress.finish()
    return _conclude(comparison, page, arguments)


def _recorded_options(arguments: argparse.Namespace) -> dict[str, Any]:
    names = ("sweep", "reference_error", "target_rmse", "warn_rmse", "fail_rmse", "keep_everything")
    return {name: getattr(arguments, name) for name in names}


def _options(core: Any, arguments: argparse.Namespace) -> Any:
    from . import compare

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
    )


def _check_exists(path: Path) -> None:
    if not path.exists():
        raise UserError(f'the scene "{path}" does not exist')


def _check_folder(folder: Path, reason: str) -> None:
    if reason:
        raise UserError(f'cannot write to the folder "{folder}": {reason}; choose another one with --out')


def _renderer(core: Any, device: str) -> Any:
    from .compare import core_errors

    with core_errors(core), interrupts.held():
        return core.Renderer(device)


def _read(core: Any, path: Path | None, arguments: argparse.Namespace) -> Any:
    """The scene as the core takes it. @raises UserError for a scene that Blender or the core refuses."""
    from . import scenes
    from .compare import core_errors

    try:
        with interrupts.held():
            scenes.import_bpy()
        with core_errors(core), interrupts.deadly():
            if path is not None:
                scenes.open_scene(path)
            return scenes.read(camera=arguments.camera, size=arguments.size, frame=arguments.frame)
    except scenes.SceneError as error:
        raise UserError(errors.sentence_of(error)) from error


def _open_file() -> str:
    """The file that Blender has open."""
    return str(sys.modules["bpy"].data.filepath) or "unsaved scene"


def _conclude(comparison: Any, page: Path, arguments: argparse.Namespace) -> int:
    """Prints what came out, and returns the exit code."""
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
            for sentence in light.sentences:
                print(f"  {sentence}")
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
        _say(f"{failure.what}: {failure.reason}")
    if comparison.failures:
        return errors.FAILED
    for limit, code, name in (
        (arguments.fail_rmse, errors.FAIL, "--fail-rmse"),
        (arguments.warn_rmse, errors.WARN, "--warn-rmse"),
    ):
        if limit is not None and worst[0] > limit:
            _say(f"{worst[1]} has a penumbra RMSE of {worst[0]:.4g}, above {name} {limit:g}")
            return code
    return errors.OK


# --- render ----------------------------------------------------------------------------------------------------------


def _render_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if _inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument("--technique", required=True, metavar="ID", help="see `penumbra techniques`")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="picture: .exr (with layers) or .png")
    parser.add_argument("--lights", type=_names, default=(), metavar="all|NAME,..", help="default: all")
    _view_arguments(parser)
    parser.add_argument("--keep-everything", action="store_true", help="leave no work out")


@command("render", "render a scene with one technique", _render_arguments)
def _render(arguments: argparse.Namespace) -> int:
    with interrupts.held():
        from . import compare, native, render
        from .files import why_not_writable
        from .progress import Progress

    if arguments.out.suffix.lower() not in (".exr", ".png"):
        raise UserError(f'--out takes a .exr or .png file, not "{arguments.out}"')
    if arguments.out.is_dir():
        raise UserError(f'"{arguments.out}" is a folder; give a file to --out')
    if arguments.scene is not None:
        _check_exists(arguments.scene)
    _check_folder(arguments.out.parent, why_not_writable(arguments.out.parent))
    core = native.load()
    settings = _settings_of(core, arguments.technique, arguments.set)
    renderer = _renderer(core, arguments.device)
    export = _read(core, arguments.scene, arguments)
    with Progress(render.work(export)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        frame = render.render(
            renderer, export, arguments.technique, settings, lights, progress, keep_everything=arguments.keep_everything
        )
        frame.write(arguments.out)
        progress.finish()
    for note in frame.notes:
        _say(note)
    for light, statistics in frame.statistics.items():
        print(f"{light}: {', '.join(f'{statistic.label} {statistic.text()}' for statistic in statistics)}")
    print(arguments.out)
    return errors.OK


# --- debug -----------------------------------------------------------------------------------------------------------


def _debug_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if _inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument("--technique", required=True, metavar="ID", help="see `penumbra techniques`")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--views", type=_names, default=(), metavar="all|ID,..", help="default: all there are")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the pictures")
    parser.add_argument("--lights", type=_names, default=(), metavar="all|NAME,..", help="default: all")
    _view_arguments(parser)


@command("debug", "draw a technique's inside: silhouettes, what grows from them, its maps", _debug_arguments)
def _debug(arguments: argparse.Namespace) -> int:
    from . import compare, debug, native
    from .files import why_not_writable
    from .progress import Progress

    if arguments.scene is not None:
        _check_exists(arguments.scene)
    _check_folder(arguments.out, why_not_writable(arguments.out))
    core = native.load()
    settings = _settings_of(core, arguments.technique, arguments.set)
    renderer = _renderer(core, arguments.device)
    export = _read(core, arguments.scene, arguments)
    with Progress(1.0 + 2.0 * len(export.lights)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        written = debug.write_views(
            renderer, export, arguments.technique, settings, lights, arguments.views, arguments.out, progress
        )
        progress.finish()
    for path, caption in written:
        print(f"{path}  {caption}")
    return errors.OK


# --- bake ------------------------------------------------------------------------------------------------------------


def _bake_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if _inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument(
        "--technique", default="plateaus", metavar="ID", help="one that makes textures; the default: plateaus"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--light", type=_names, default=(), dest="lights", metavar="all|NAME,..", help="default: all")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for images, planes.json and .obj"
    )
    parser.add_argument("--format", choices=("png", "exr"), default="png", help="8 bits, or float; default: png")
    _view_arguments(parser)


@command("bake", "save the shadow on each plane as a texture with its place and UVs", _bake_arguments)
def _bake(arguments: argparse.Namespace) -> int:
    from . import bake, compare, native
    from .files import why_not_writable
    from .progress import Progress

    if arguments.scene is not None:
        _check_exists(arguments.scene)
    _check_folder(arguments.out, why_not_writable(arguments.out))
    core = native.load()
    settings = _settings_of(core, arguments.technique, arguments.set)
    renderer = _renderer(core, arguments.device)
    export = _read(core, arguments.scene, arguments)
    with Progress(1.0 + 2.0 * len(export.lights)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        textures = bake.bake(renderer, export, arguments.technique, settings, lights, progress)
        written = bake.write(textures, arguments.out, f".{arguments.format}")
        progress.finish()
    for path in written:
        print(path)
    return errors.OK


def _settings_of(core: Any, technique: str, texts: Sequence[str]) -> dict[str, Any]:
    """KEY=VALUE texts as checked settings of one technique. @raises UserError"""
    from . import compare

    infos = core.techniques()
    compare.choose_techniques(infos, (technique,))
    prefix = f"{technique}."
    parsed = [compare.parse_setting(infos, prefix + text.removeprefix(prefix)) for text in texts]
    return {key: value for _, key, value in parsed}


# --- techniques ------------------------------------------------------------------------------------------------------


def _techniques_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="for programs")
    parser.add_argument("--rules", action="store_true", help="the rules that leave work out, instead")


@command("techniques", "list techniques, the lights they serve and their settings", _techniques_arguments)
def _techniques(arguments: argparse.Namespace) -> int:
    from . import listing, native

    core = native.load()
    entries = core.rules() if arguments.rules else core.techniques()
    if arguments.json:
        print(json.dumps(entries, indent=1))
    else:
        print(listing.rules_text(entries) if arguments.rules else listing.techniques_text(entries))
    return errors.OK


# --- doctor ----------------------------------------------------------------------------------------------------------


def _doctor_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="for programs")
    parser.add_argument("--device", default="", metavar="D", help="EGL device: its number or a part of its name")


@command("doctor", "say what works here and what to install", _doctor_arguments)
def _doctor(arguments: argparse.Namespace) -> int:
    from . import doctor

    checks = doctor.examine(arguments.device)
    if arguments.json:
        print(json.dumps(doctor.to_json(checks), indent=1))
    else:
        print(doctor.text(checks))
    return errors.OK if doctor.healthy(checks) else errors.FAILED


# --- running ---------------------------------------------------------------------------------------------------------


def _inside_blender() -> bool:
    """True in Blender's own program, where a file may be open; False for Blender as a Python module."""
    bpy = sys.modules.get("bpy")
    return bpy is not None and bool(getattr(bpy.app, "binary_path", ""))


def _say(sentence: str) -> None:
    print(f"penumbra: {sentence}", file=sys.stderr, flush=True)


def _debugging() -> bool:
    return os.environ.get("PENUMBRA_TRACEBACK") == "1"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code. No traceback reaches the user unless PENUMBRA_TRACEBACK=1."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    interrupts.listen()
    try:
        parsed = _parser().parse_args(given)
        parsed.given = given
        code: int = parsed.run(parsed)
        sys.stdout.flush()
        return code
    except SystemExit as leaving:  # --help and --version
        return leaving.code if isinstance(leaving.code, int) else errors.OK
    except UserError as error:
        if _debugging():
            traceback.print_exc()
        _say(str(error))
        return errors.BAD_INPUT
    except KeyboardInterrupt:
        _say("interrupted")
        return errors.INTERRUPTED
    except BrokenPipeError:  # `penumbra techniques | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return errors.OK
    except Exception as error:
        if _debugging():
            traceback.print_exc()
        what = "out of memory" if isinstance(error, MemoryError) else errors.sentence_of(error)
        _say(f"{what} ({type(error).__name__}; set PENUMBRA_TRACEBACK=1 for details)")
        return errors.FAILED
