"""`penumbra techniques` and `penumbra doctor`: what there is, and what works here."""

from __future__ import annotations

import argparse
import json

from .. import errors
from .arguments import machine_arguments
from .registry import command


def _techniques_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="for programs")
    parser.add_argument("--rules", action="store_true", help="the rules that leave work out, instead")


@command("techniques", "list techniques, the lights they serve and their settings", _techniques_arguments)
def _techniques(arguments: argparse.Namespace) -> int:
    from .. import listing, native

    core = native.load()
    entries = core.rules() if arguments.rules else core.techniques()
    if arguments.json:
        print(json.dumps(entries, indent=1))
    elif arguments.rules:
        print(listing.rules_text(entries, len(core.techniques())))
    else:
        print(listing.techniques_text(entries))
    return errors.OK


def _doctor_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="for programs")
    machine_arguments(parser)


@command("doctor", "say what works here and what to install", _doctor_arguments)
def _doctor(arguments: argparse.Namespace) -> int:
    from .. import doctor

    checks = doctor.examine(arguments.device, arguments.view_by)
    if arguments.json:
        print(json.dumps(doctor.to_json(checks), indent=1))
    else:
        print(doctor.text(checks))
    return errors.OK if doctor.healthy(checks) else errors.FAILED
