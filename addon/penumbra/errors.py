"""What the command line says in one sentence, and the exit code that goes with it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

OK = 0
FAILED = 1  # something failed on the way; the rest is delivered
BAD_INPUT = 2  # nothing was done, nothing written
WARN = 3
FAIL = 4
INTERRUPTED = 130


class UserError(Exception):
    """Bad usage or bad input: one sentence, no traceback, exit code 2."""

    def __init__(self, sentence: str) -> None:
        super().__init__(printable(sentence))


def unknown(what: str, given: str, choices: Iterable[str]) -> UserError:
    """ "unknown technique "pfc"; did you mean pcf? There are: ..." """
    names = list(choices)
    close = difflib.get_close_matches(given, names, n=1, cutoff=0.6)
    hint = f"did you mean {close[0]}? " if close else ""
    listed = ", ".join(names) if names else "none"
    return UserError(f'unknown {what} "{given}"; {hint}choose from: {listed}')


def printable(text: str) -> str:
    """What is quoted may hold line ends, escape sequences and halves of characters; a sentence stays one line."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def sentence_of(error: BaseException) -> str:
    """The first line of an exception's message, without its full stop, or its class name if it has none."""
    lines = str(error).strip().splitlines()
    return lines[0].rstrip(".") if lines else type(error).__name__
