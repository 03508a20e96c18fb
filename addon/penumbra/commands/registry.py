"""The list of subcommands, and the parser made of it."""

from __future__ import annotations

import argparse
import difflib
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

from .. import __version__
from ..errors import UserError

Run = Callable[[argparse.Namespace], int]


@dataclass(frozen=True)
class _Command:
    name: str
    summary: str  # empty: not for users, and not listed
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Run


_COMMANDS: list[_Command] = []


def command(name: str, summary: str, add_arguments: Callable[[argparse.ArgumentParser], None]) -> Callable[[Run], Run]:
    """Makes the function a subcommand. It gets the parsed arguments and returns an exit code."""

    def register(run: Run) -> Run:
        _COMMANDS.append(_Command(name, summary, add_arguments, run))
        return run

    return register


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence, without the usage text."""

    def error(self, message: str) -> NoReturn:
        match = re.match(r"argument (\S+): invalid choice: '?(.*?)'? \(choose from (.*)\)", message)
        if match:
            hidden = [entry.name for entry in _COMMANDS if not entry.summary]
            names = [name for name in (name.strip(" '") for name in match[3].split(",")) if name not in hidden]
            close = difflib.get_close_matches(match[2], names, n=1, cutoff=0.6)
            hint = f"did you mean {close[0]}? " if close else ""
            what = "command" if match[1] == "COMMAND" else f"value of {match[1]}"
            message = f'unknown {what} "{match[2]}"; {hint}choose from: {", ".join(names)}'
        elif message.startswith("unrecognized arguments: "):
            message = self._unrecognised(message.removeprefix("unrecognized arguments: "))
        raise UserError(f"{message} (see {self.prog} --help)")

    def _unrecognised(self, text: str) -> str:
        given = next(iter(text.split()), text)
        options = [option for action in self._actions for option in action.option_strings]
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                parsers = action.choices.values()
                options += [
                    option for parser in parsers for inner in parser._actions for option in inner.option_strings
                ]
        close = difflib.get_close_matches(given.split("=")[0], options, n=1, cutoff=0.6)
        return f'unknown option "{given}"' + (f", did you mean {close[0]}?" if close else "")


def parser() -> Parser:
    made = Parser(
        prog="penumbra",
        description="Renders classic soft-shadow techniques on a Blender scene and reports error against time.",
        epilog="Exit codes: 0 done; 1 something failed on the way; 2 bad usage or input; 3 and 4 an error is above "
        "--warn-rmse / --fail-rmse; 130 interrupted.",
    )
    made.add_argument("--version", action="version", version=f"penumbra {__version__}")
    commands = made.add_subparsers(metavar="COMMAND", dest="command", required=True, parser_class=Parser)
    for entry in _COMMANDS:
        shown: dict[str, Any] = {"help": entry.summary} if entry.summary else {}
        description = entry.summary[:1].upper() + entry.summary[1:] + "."
        sub = commands.add_parser(entry.name, description=description, **shown)
        entry.add_arguments(sub)
        sub.set_defaults(run=entry.run)
    return made
