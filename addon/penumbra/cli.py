"""The command line: one program, inside Blender (`blender -b shot.blend --command penumbra ...`) and out.

A subcommand is one function decorated with @command, in `commands`; its parser lies beside it. Exit codes: 0 all was
done; 1 something failed on the way; 2 bad usage or bad input, nothing written; 3 and 4 an error is above --warn-rmse /
--fail-rmse; 130 interrupted (by the signal itself while a scene is read, which a shell tells as 130 too).
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence

from . import errors, interrupts
from .commands import asking, batch, changes, comparing, registry, rendering, stability
from .commands.scene import say
from .errors import UserError

__all__ = ["asking", "batch", "changes", "comparing", "main", "rendering", "stability"]  # imported to be registered


def _debugging() -> bool:
    return os.environ.get("PENUMBRA_TRACEBACK") == "1"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code. No traceback reaches the user unless PENUMBRA_TRACEBACK=1."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    interrupts.listen()
    try:
        parsed = registry.parser().parse_args(given)
        parsed.given = given
        code: int = parsed.run(parsed)
        sys.stdout.flush()
        return code
    except SystemExit as leaving:  # --help and --version
        return leaving.code if isinstance(leaving.code, int) else errors.OK
    except UserError as error:
        if _debugging():
            traceback.print_exc()
        say(str(error))
        return errors.BAD_INPUT
    except KeyboardInterrupt:
        say("interrupted")
        return errors.INTERRUPTED
    except BrokenPipeError:  # `penumbra techniques | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return errors.OK
    except Exception as error:
        if _debugging():
            traceback.print_exc()
        what = "out of memory" if isinstance(error, MemoryError) else errors.sentence_of(error)
        say(f"{what} ({type(error).__name__}; set PENUMBRA_TRACEBACK=1 for details)")
        return errors.FAILED
