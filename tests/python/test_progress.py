from __future__ import annotations

import io
import re

import pytest
from penumbra import progress
from penumbra.progress import Progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_log_gets_few_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(10_000))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock) * 0.5)
    log = io.StringIO()
    with Progress(10.0, log) as bar:
        bar.stage("reference", 10.0)
        for i in range(100):
            bar(i / 100)
    lines = log.getvalue().splitlines()
    assert 3 <= len(lines) <= 8
    shares = [int(re.match(r"\s*(\d+)%", line)[1]) for line in lines]  # type: ignore[index]
    assert shares == sorted(shares)
    assert all("reference" in line for line in lines)


def test_a_terminal_gets_a_bar_that_is_gone_at_the_end() -> None:
    terminal = Terminal()
    with Progress(2.0, terminal) as bar:
        bar.stage("first [b]", 1.0)
        bar(0.5, "rays")
        bar.stage("second", 1.0)
        bar.finish()
    assert "first [b]" in terminal.getvalue()
    assert "100 %" in terminal.getvalue()


def test_progress_within_a_stage_never_falls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "_LINE_INTERVAL_S", 0.0)
    log = io.StringIO()
    with Progress(1.0, log) as bar:
        bar.stage("timing", 1.0)
        for share in (0.5, 0.1, 0.7, 2.0, -1.0):
            bar(share)
    shares = [int(re.match(r"\s*(\d+)%", line)[1]) for line in log.getvalue().splitlines()]  # type: ignore[index]
    assert shares == [0, 50, 50, 70, 100, 100]


def test_nothing_is_shown_when_not_asked_for() -> None:
    log = io.StringIO()
    with Progress(1.0, log, show=False) as bar:
        bar.stage("a", 1.0)
        bar.note("note")
        bar.finish()
    assert log.getvalue() == ""
