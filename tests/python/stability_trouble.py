"""Cases for the tests of `penumbra stability`: workers that die, hang, eat memory, fail and go on."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Sequence

from penumbra.stability import scenes
from penumbra.stability.cases import Case
from penumbra.stability.setups import Setup


def _die() -> Sequence[Setup]:
    os.kill(os.getpid(), signal.SIGSEGV)
    return ()


def _hang() -> Sequence[Setup]:
    time.sleep(3600.0)
    return ()


def _eat() -> Sequence[Setup]:
    eaten = []
    while True:
        eaten.append(bytearray(64 << 20))


def _fail() -> Sequence[Setup]:
    raise RuntimeError("it cannot be built")


CASES = (
    Case("dies", "its process dies", _die),
    Case("hangs", "it never ends", _hang, ends_s=0.5),
    Case("eats", "it wants all memory", _eat, memory_mb=512.0),
    Case("fails", "it raises", _fail),
    Case("goes-well", "one that works", lambda: (scenes.yard(0.0),), truth="rays"),
)
