"""`penumbra render`, `penumbra debug` and `penumbra bake`: pictures with one technique."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import errors, interrupts
from ..errors import UserError
from .arguments import names, view_arguments
from .registry import command
from .scene import check_exists, check_folder, inside_blender, make_renderer, read, say, settings_of


def _render_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument("--technique", required=True, metavar="ID", help="see `penumbra techniques`")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="picture: .exr (with layers) or .png")
    parser.add_argument("--lights", type=names, default=(), metavar="all|NAME,..", help="default: all")
    view_arguments(parser)
    parser.add_argument("--keep-everything", action="store_true", help="leave no work out")


@command("render", "render a scene with one technique", _render_arguments)
def _render(arguments: argparse.Namespace) -> int:
    with interrupts.held():
        from .. import compare, native, render
        from ..files import why_not_writable
        from ..progress import Progress

    if arguments.out.suffix.lower() not in (".exr", ".png"):
        raise UserError(f'--out takes a .exr or .png file, not "{arguments.out}"')
    if arguments.out.is_dir():
        raise UserError(f'"{arguments.out}" is a folder; give a file to --out')
    if arguments.scene is not None:
        check_exists(arguments.scene)
    check_folder(arguments.out.parent, why_not_writable(arguments.out.parent))
    core = native.load()
    settings = settings_of(core, arguments.technique, arguments.set)
    renderer = make_renderer(core, arguments.device, arguments.view_by)
    export = read(core, arguments.scene, arguments)
    with Progress(render.work(export)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        frame = render.render(
            renderer, export, arguments.technique, settings, lights, progress, keep_everything=arguments.keep_everything
        )
        frame.write(arguments.out)
        progress.finish()
    for note in frame.notes + frame.warnings:
        say(note)
    for light, statistics in frame.statistics.items():
        print(f"{light}: {', '.join(f'{statistic.label} {statistic.text()}' for statistic in statistics)}")
    print(arguments.out)
    return errors.OK


def _debug_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument("--technique", required=True, metavar="ID", help="see `penumbra techniques`")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--views", type=names, default=(), metavar="all|ID,..", help="default: all there are")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the pictures")
    parser.add_argument("--lights", type=names, default=(), metavar="all|NAME,..", help="default: all")
    view_arguments(parser)


@command("debug", "draw a technique's inside: silhouettes, what grows from them, its maps", _debug_arguments)
def _debug(arguments: argparse.Namespace) -> int:
    from .. import compare, debug, native
    from ..files import why_not_writable
    from ..progress import Progress

    if arguments.scene is not None:
        check_exists(arguments.scene)
    check_folder(arguments.out, why_not_writable(arguments.out))
    core = native.load()
    settings = settings_of(core, arguments.technique, arguments.set)
    renderer = make_renderer(core, arguments.device, arguments.view_by)
    export = read(core, arguments.scene, arguments)
    with Progress(1.0 + 2.0 * len(export.lights)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        written = debug.write_views(
            renderer, export, arguments.technique, settings, lights, arguments.views, arguments.out, progress
        )
        progress.finish()
    for path, caption in written:
        print(f"{path}  {caption}")
    return errors.OK


def _bake_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?" if inside_blender() else None, type=Path, metavar="SCENE")
    parser.add_argument(
        "--technique", default="plateaus", metavar="ID", help="one that makes textures; the default: plateaus"
    )
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting; may be repeated")
    parser.add_argument("--light", type=names, default=(), dest="lights", metavar="all|NAME,..", help="default: all")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for images, planes.json and .obj"
    )
    parser.add_argument("--format", choices=("png", "exr"), default="png", help="8 bits, or float; default: png")
    view_arguments(parser)


@command("bake", "save the shadow on each plane as a texture with its place and UVs", _bake_arguments)
def _bake(arguments: argparse.Namespace) -> int:
    from .. import bake, compare, native
    from ..files import why_not_writable
    from ..progress import Progress

    if arguments.scene is not None:
        check_exists(arguments.scene)
    check_folder(arguments.out, why_not_writable(arguments.out))
    core = native.load()
    settings = settings_of(core, arguments.technique, arguments.set)
    renderer = make_renderer(core, arguments.device, arguments.view_by)
    export = read(core, arguments.scene, arguments)
    with Progress(1.0 + 2.0 * len(export.lights)) as progress, compare.core_errors(core):
        lights = compare.choose_lights(list(export.lights), arguments.lights)
        textures = bake.bake(renderer, export, arguments.technique, settings, lights, progress)
        written = bake.write(textures, arguments.out, f".{arguments.format}")
        progress.finish()
    for path in written:
        print(path)
    return errors.OK
