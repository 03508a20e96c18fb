"""Ctrl-C, heard at any time: also while Blender, which brings its own idea of signals, loads and reads files."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator

_SHOW_CURSOR = b"\x1b[?25h"


def listen() -> None:
    """Ctrl-C becomes a KeyboardInterrupt."""
    _handle(signal.default_int_handler)


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Keeps Ctrl-C until the end of the block, and listens from there on.

    For `import bpy`, which puts in a handler of its own that swallows the signal, and for what makes threads before it:
    they inherit the deafness, where one thread that hears would take the signal for all.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        listen()
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def deadly() -> Iterator[None]:
    """Within the block Ctrl-C ends the process at once, as the system does it: a shell tells 130.

    For calls of Blender that take long, hear nothing and let no other thread of Python run, such as evaluating a scene.
    Nothing may be half written then. Blender's empty folder for temporary files is left behind.
    """
    with contextlib.suppress(OSError):
        if os.isatty(2):
            os.write(2, _SHOW_CURSOR)  # which a progress bar hides; past sys.stderr, which the bar replaces
    _handle(signal.SIG_DFL)
    try:
        yield
    finally:
        listen()


def _handle(handler: signal._HANDLER) -> None:
    with contextlib.suppress(ValueError):  # not the main thread: whoever called us listens
        signal.signal(signal.SIGINT, handler)
