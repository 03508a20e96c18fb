"""`penumbra compare-reports`: what changed between two reports."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .. import errors
from ..errors import UserError
from .arguments import between
from .registry import command
from .scene import check_folder, say

_ratio = between(1.0, 1e6)


def _changes_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=Path, metavar="A", help="report.json, or its folder: before")
    parser.add_argument("b", type=Path, metavar="B", help="report.json, or its folder: after")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for changes.html and changes.json")
    parser.add_argument("--json", action="store_true", help="print changes.json, for programs")
    parser.add_argument(
        "--warn-slower", type=_ratio, metavar="R", help="exit code 3 if a frame takes more than R times as long"
    )
    parser.add_argument(
        "--fail-slower", type=_ratio, metavar="R", help="exit code 4 if a frame takes more than R times as long"
    )
    parser.add_argument(
        "--warn-worse", type=_ratio, metavar="R", help="exit code 3 if an error is more than R times as large"
    )
    parser.add_argument(
        "--fail-worse", type=_ratio, metavar="R", help="exit code 4 if an error is more than R times as large"
    )
    parser.add_argument("--fail-missing", action="store_true", help="exit code 4 if B lacks something that A has")


@command("compare-reports", "say what changed from one report to another", _changes_arguments)
def _changes(arguments: argparse.Namespace) -> int:
    from ..changes import match, read, text
    from ..files import why_not_writable, write_bytes

    if arguments.out is not None:
        check_folder(arguments.out, why_not_writable(arguments.out))
    found = match.changes(read.read(arguments.a), read.read(arguments.b))
    if not found.scenes:
        raise UserError("the two reports have no scene in common; they are matched by file name, camera and frame")
    document = json.dumps(text.to_json(found), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    if arguments.json:
        print(document, end="")
    else:
        for line in text.lines(found):
            print(line)
    if arguments.out is not None:
        from ..changes import page

        arguments.out.mkdir(parents=True, exist_ok=True)
        write_bytes(arguments.out / "changes.json", document.encode())
        target = arguments.out / "changes.html"
        write_bytes(target, page.page(found).encode())
        if not arguments.json:
            print(f"page: {target}")
    limits = text.Limits(
        arguments.warn_slower,
        arguments.fail_slower,
        arguments.warn_worse,
        arguments.fail_worse,
        arguments.fail_missing,
    )
    code, sentences = text.gate(found, limits)
    for sentence in sentences:
        say(sentence)
    return code if code else errors.OK
