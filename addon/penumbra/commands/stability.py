"""`penumbra stability`: every technique on hard cases. What they are is in the package `stability`."""

from __future__ import annotations

import argparse
from fnmatch import fnmatchcase
from pathlib import Path

from .. import errors, interrupts
from ..errors import UserError
from .arguments import machine_arguments, names
from .registry import command
from .scene import check_folder, make_renderer, say


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for stability.json and its page")
    parser.add_argument(
        "--techniques", type=names, default=(), metavar="all|ID,ID", help="see `penumbra techniques`; default: all"
    )
    parser.add_argument(
        "--cases", type=names, default=(), metavar="all|NAME,..", help="names, * stands for anything; default: all"
    )
    parser.add_argument("--quick", action="store_true", help="a third of the cases")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the Markdown page here as well")
    machine_arguments(parser)


@command("stability", "try every technique on hard cases and say what holds, with bounds", _arguments)
def _stability(arguments: argparse.Namespace) -> int:
    with interrupts.held():
        from .. import compare, environment, native
        from ..files import why_not_writable, write_bytes
        from ..progress import Progress
        from ..stability import document, run
        from ..stability.cases import CASES, QUICK

    check_folder(arguments.out, why_not_writable(arguments.out))
    if arguments.page is not None:
        check_folder(arguments.page.parent, why_not_writable(arguments.page.parent))
    core = native.load()
    techniques = [info["id"] for info in compare.choose_techniques(core.techniques(), arguments.techniques)]
    for pattern in arguments.cases:
        if not any(fnmatchcase(case.id, pattern) for case in CASES):
            raise errors.unknown("case", pattern, [case.id for case in CASES])
    cases = [
        case
        for case in CASES
        if (case.id in QUICK or not arguments.quick)
        and (not arguments.cases or any(fnmatchcase(case.id, pattern) for pattern in arguments.cases))
    ]
    if not cases:
        raise UserError("no case is both among --cases and --quick; leave --quick away")
    described = environment.collect(core, make_renderer(core, arguments.device, arguments.view_by), arguments.given)
    with Progress(len(cases)) as progress:
        progress.stage("stability", len(cases))
        rows = list(
            run.run(
                techniques,
                cases,
                lambda done, text: progress(done / len(cases), text),
                device=arguments.device,
                view_by=arguments.view_by,
            )
        )
        progress.finish()
    written = document.write(arguments.out, described, cases, techniques, rows)
    if arguments.page is not None:
        write_bytes(arguments.page, written[1].read_bytes())
    for finding in document.findings(rows):
        if finding.outcome == "violated":
            say(f"{', '.join(finding.cases)}: {', '.join(finding.techniques)}: {finding.property}: {finding.reason}")
    print(", ".join(f"{outcome} {number}" for outcome, number in document.counts(rows).items()))
    print(f"report: {written[2]}")
    return errors.FAILED if document.counts(rows)["violated"] else errors.OK


def _worker_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--channel", type=int, required=True, metavar="FD", help="the pipe to its parent")


@command("stability-worker", "", _worker_arguments)
def _worker(arguments: argparse.Namespace) -> int:
    from ..stability import worker

    return worker.serve(arguments.channel)
