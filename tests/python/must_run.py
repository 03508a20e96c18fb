"""What a test does where the machine lacks something."""

from __future__ import annotations

import os
from typing import NoReturn

import pytest


def skip(reason: str) -> NoReturn:
    """For what the machine lacks. Where PENUMBRA_MUST_RUN is set, as ./test does, that is a failure: a broken driver
    must not pass for a short list of tests."""
    if os.environ.get("PENUMBRA_MUST_RUN"):
        pytest.fail(f"must run here, but {reason}")
    pytest.skip(reason)
