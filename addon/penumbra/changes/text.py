"""What changed, as lines for people, as JSON for programs, and as an exit code for gates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from .. import errors, verdict
from ..records import settings_text
from .match import Changes, Pair, Ratio, TechniqueChanges, TimeChange
from .read import Report

SCHEMA = 1
_MOST_LINES = 60  # of changed records; the page and the JSON have them all

TIME_WORDS = {"same": "", "less": "faster", "more": "slower", "unknown": "too few runs"}
ERROR_WORDS = {"same": "", "less": "more accurate", "more": "less accurate", "unknown": ""}


@dataclass(frozen=True)
class Limits:
    """From which ratio of B to A on a gate closes; None: never."""

    warn_slower: float | None = None
    fail_slower: float | None = None
    warn_worse: float | None = None
    fail_worse: float | None = None
    fail_missing: bool = False


def lines(changes: Changes) -> Iterator[str]:
    """The whole of standard output."""
    yield f"A: {report_line(changes.a)}"
    yield f"B: {report_line(changes.b)}"
    for name, a, b in changes.environment:
        yield f"  {name}: {a} -> {b}"
    for name, a, b in changes.options:
        yield f"  option {name}: {a} -> {b}"
    for scene in changes.scenes:
        for note in scene.notes:
            yield f"{scene.name}: {note}"
    yield from changes.missing
    changed = [(scene, light, pair) for scene, light, pair in changes.pairs() if pair.changes]
    here = ""
    for scene, light, pair in changed[:_MOST_LINES]:
        where = f"{scene.name}, {light.name} ({light.shape})"
        if where != here:
            yield where
            here = where
        yield f"  {pair_line(pair)}"
    if len(changed) > _MOST_LINES:
        yield f"  and {len(changed) - _MOST_LINES} more"
    count = sum(1 for _ in changes.pairs())
    yield f"{count} records in both reports, {len(changed)} changed."
    if changes.overall is not None:
        yield "Time of B over A, geometric means of dynamic frames:"
        for technique in changes.techniques:
            yield f"  {technique_line(technique)}"
        yield f"  {'all':<20} {ratio_text(changes.overall)}"


def report_line(report: Report) -> str:
    return f"{report.path}: {', '.join(facts(report))}"


def facts(report: Report) -> list[str]:
    """Version, processor, OpenGL and date, as far as they are told."""
    told = {name: str(value) for name, value in report.environment.items() if value not in (None, "")}
    commit = f" ({told['commit'][:10]})" if "commit" in told else ""
    date = told.get("date", "")[:16].replace("T", " ")
    found = [f"Penumbra {told.get('penumbra', '?')}{commit}", told.get("cpu", ""), told.get("gl_renderer", ""), date]
    return [fact for fact in found if fact]


def pair_line(pair: Pair) -> str:
    if pair.a_status != pair.b_status:
        return f"{pair.label}: {pair.a_status} -> {pair.b_status}: {pair.reason}"
    parts = []
    if pair.error is not None and pair.error.call != "same":
        parts.append(f"error {pair.error.a:.4g} -> {pair.error.b:.4g}, {ERROR_WORDS[pair.error.call]}")
    for time in pair.times:
        if time.call in ("less", "more"):
            parts.append(time_text(time))
    for step in pair.plan:
        parts.append(f"{step.step}: {step.a or 'none'} -> {step.b or 'none'}" + f" ({step.reason})" * bool(step.reason))
    return f"{pair.label}: {'; '.join(parts)}"


def time_text(time: TimeChange) -> str:
    shown = f"{verdict.milliseconds(time.a_ms)} -> {verdict.milliseconds(time.b_ms)}"
    return f"{time.frame} frame {shown}, {ratio_text(time.ratio)}, {TIME_WORDS[time.call]}"


def ratio_text(ratio: Ratio) -> str:
    """ "x 0.741 (0.705 to 0.779)"."""
    return f"x {_short(ratio.value)} ({_short(ratio.low)} to {_short(ratio.high)})"


def _short(value: float) -> str:
    return f"{value:.0f}" if 100 <= value < 1e6 else f"{value:#.3g}"


def technique_line(technique: TechniqueChanges) -> str:
    shown = ratio_text(technique.time) if technique.time is not None else "too few runs"
    counts = [f"{technique.pairs} record{'s' if technique.pairs != 1 else ''}"]
    for count, word in (
        (technique.faster, "faster"),
        (technique.slower, "slower"),
        (technique.better, "more accurate"),
        (technique.worse, "less accurate"),
    ):
        counts += [f"{count} {word}"] if count else []
    return f"{technique.technique:<20} {shown}  {', '.join(counts)}"


def gate(changes: Changes, limits: Limits) -> tuple[int, list[str]]:
    """The exit code, and a sentence for each limit that is passed; the worst pair is named."""
    found: list[tuple[int, str]] = []
    slower = [(time.ratio.value, pair, where, time) for where, pair in _placed(changes) for time in _slower(pair)]
    worse = [(_growth(pair), pair, where) for where, pair in _placed(changes) if _is_worse(pair)]
    for limit, code, option in (
        (limits.fail_slower, errors.FAIL, "--fail-slower"),
        (limits.warn_slower, errors.WARN, "--warn-slower"),
    ):
        above = [entry for entry in slower if limit is not None and entry[0] > limit]
        if above:
            value, pair, where, time = max(above, key=lambda entry: entry[0])
            others = f", and {len(above) - 1} more" if len(above) > 1 else ""
            said = f"{pair.label} at {where}: its {time.frame} frame takes {_short(value)} times as long"
            found.append((code, f"{said}, above {option} {limit:g}{others}"))
    for limit, code, option in (
        (limits.fail_worse, errors.FAIL, "--fail-worse"),
        (limits.warn_worse, errors.WARN, "--warn-worse"),
    ):
        grown = [entry for entry in worse if limit is not None and entry[0] > limit]
        if grown:
            value, pair, where = max(grown, key=lambda entry: entry[0])
            others = f", and {len(grown) - 1} more" if len(grown) > 1 else ""
            found.append((code, f"{pair.label} at {where}: {_worsening(pair)}, above {option} {limit:g}{others}"))
    if limits.fail_missing:
        gone = [text for text in changes.missing if text.endswith("only in A")]
        if gone:
            others = f", and {len(gone) - 1} more" if len(gone) > 1 else ""
            found.append((errors.FAIL, f"{gone[0]}{others}, and --fail-missing is set"))
    return max((code for code, _ in found), default=errors.OK), [sentence for _, sentence in found]


def _placed(changes: Changes) -> list[tuple[str, Pair]]:
    return [(f"{light.name} in {scene.name}", pair) for scene, light, pair in changes.pairs()]


def _slower(pair: Pair) -> list[TimeChange]:
    return [time for time in pair.times if time.call == "more"]


def _is_worse(pair: Pair) -> bool:
    failed = pair.a_status == "ok" and pair.b_status != "ok"
    return failed or (pair.error is not None and pair.error.call == "more")


def _growth(pair: Pair) -> float:
    """What was measured and is no more is worse than any error."""
    if pair.error is None or pair.error.a <= 0.0:
        return math.inf
    return pair.error.b / pair.error.a


def _worsening(pair: Pair) -> str:
    if pair.error is None:
        return f"{pair.b_status} ({pair.reason})"
    return f"its error grew from {pair.error.a:.4g} to {pair.error.b:.4g}"


def to_json(changes: Changes) -> dict[str, Any]:
    """changes.json: every pair with its figures."""
    return {
        "schema": SCHEMA,
        "a": {"path": str(changes.a.path), "environment": changes.a.environment},
        "b": {"path": str(changes.b.path), "environment": changes.b.environment},
        "environment": [_named(entry) for entry in changes.environment],
        "options": [_named(entry) for entry in changes.options],
        "missing": changes.missing,
        "overall": asdict(changes.overall) if changes.overall is not None else None,
        "techniques": [asdict(technique) for technique in changes.techniques],
        "scenes": [asdict(scene) for scene in changes.scenes],
    }


def _named(entry: tuple[str, str, str]) -> dict[str, str]:
    name, a, b = entry
    return {"name": name, "a": a, "b": b}


def settings_of(pair: Pair) -> str:
    return settings_text(pair.changed) or "as asked for"
