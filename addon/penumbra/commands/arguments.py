"""Types of arguments, and the options that several subcommands have."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable

from ..native import VIEWS


def size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9})[xX×](\d{1,9})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if not all(1 <= side <= 16384 for side in size):
        raise argparse.ArgumentTypeError(f'"{text}" is not a size such as 640x360, each side from 1 to 16384')
    return size


def names(text: str) -> tuple[str, ...]:
    """ "all" is the empty tuple."""
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise argparse.ArgumentTypeError('give "all" or names separated by commas')
    return () if names == ("all",) else names


def between(low: float, high: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f'"{text}" is not a number from {low:g} to {high:g}')
        return value

    return parse


error = between(0.0, 1.0)


def frame_number(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 1 << 30
    if abs(value) > 1048574:  # Blender's own limit
        raise argparse.ArgumentTypeError(f'"{text}" is not a frame number')
    return value


def frames(text: str) -> tuple[int, ...]:
    """ "1-10,20-30:5"."""
    from ..batch.jobs import parse_frames

    try:
        return parse_frames(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def view_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--camera", metavar="NAME", help="camera object; default: the scene's active one")
    parser.add_argument("--frame", type=frame_number, metavar="N", help="frame; default: the file's current one")
    parser.add_argument("--size", type=size, metavar="WxH", help="picture size in pixels; default: the scene's")
    machine_arguments(parser)


def machine_arguments(parser: argparse.ArgumentParser) -> None:
    """What the renderer runs on, and how: see native.renderer()."""
    parser.add_argument("--device", default="", metavar="D", help="EGL device: its number or a part of its name")
    parser.add_argument(
        "--view-by", choices=VIEWS, default="",
        help="what finds the triangle in each pixel: OpenGL, or camera rays, which are faster without a graphics card; "
        "default: $PENUMBRA_VIEW_BY, else raster",
    )  # fmt: skip


def compare_options(parser: argparse.ArgumentParser, sweep: str) -> None:
    comparison_options(parser, sweep)
    view_arguments(parser)


def comparison_options(parser: argparse.ArgumentParser, sweep: str) -> None:
    """What is compared, and how well; without the view."""
    parser.add_argument(
        "--techniques", type=names, default=(), metavar="all|ID,ID", help="see `penumbra techniques`; default: all"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="TECHNIQUE.KEY=VALUE", help="a setting; may be repeated"
    )
    parser.add_argument("--lights", type=names, default=(), metavar="all|NAME,..", help="default: all")
    parser.add_argument(
        "--sweep", choices=("off", "quick", "full"), default=sweep,
        help=f"vary the quality settings, which gives the error-versus-time curves; default: {sweep}",
    )  # fmt: skip
    parser.add_argument(
        "--reference-error", type=between(1e-5, 0.5), default=0.002, metavar="E",
        help="standard error of the reference, per pixel, of V; default: 0.002",
    )  # fmt: skip
    parser.add_argument(
        "--timing-seconds", type=between(0.01, 3600.0), default=3.0, metavar="S",
        help="spend at most about S on each median; most are tight sooner; default: 3",
    )  # fmt: skip
    parser.add_argument(
        "--target-rmse", type=error, metavar="E", help="pick the cheapest setting within this error, say what it saves"
    )
    parser.add_argument("--warn-rmse", type=error, metavar="E", help="exit code 3 if a penumbra RMSE is above")
    parser.add_argument("--fail-rmse", type=error, metavar="E", help="exit code 4 if a penumbra RMSE is above")
    parser.add_argument("--keep-everything", action="store_true", help="leave no work out")
    parser.add_argument(
        "--measure-savings", action="store_true", help="time each technique with nothing left out as well"
    )
    parser.add_argument("--no-cache", action="store_true", help="trace the references anew and keep none")
