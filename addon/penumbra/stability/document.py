"""The outcome of a run: stability.json, and the same as a page (Markdown, HTML)."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..files import write_bytes
from . import limits
from .cases import Case
from .rows import OUTCOMES, SCHEMA, Outcome, Row, worst

_MARKS: Mapping[Outcome, str] = {"holds": "✓", "bounded": "b", "known_limit": "L", "violated": "✗"}
_MEANING: Mapping[Outcome, str] = {
    "holds": "all that is asked holds",
    "bounded": "off by the method's own error, within the figure below",
    "known_limit": "outside the method's field of use, as below",
    "violated": "wrong",
}


@dataclass(frozen=True)
class Finding:
    """Rows with one reason, taken together."""

    outcome: Outcome
    property: str
    reason: str
    bound: float
    value: float | None  # the worst
    cases: tuple[str, ...]
    techniques: tuple[str, ...]


def write(
    out: Path, environment: Mapping[str, Any], cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]
) -> list[Path]:
    """@return the files, that for programs first"""
    text = markdown(environment, cases, techniques, rows)
    document = {"schema": SCHEMA, "environment": dict(environment), "rows": [row.to_json() for row in rows]}
    files = {
        "stability.json": json.dumps(document, indent=1, allow_nan=False) + "\n",
        "stability.md": text,
        "stability.html": _html(environment, cases, techniques, rows),
    }
    out.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        write_bytes(out / name, content.encode())
    return [out / name for name in files]


def counts(rows: Sequence[Row]) -> dict[Outcome, int]:
    return {outcome: sum(row.outcome == outcome for row in rows) for outcome in OUTCOMES}


def findings(rows: Sequence[Row]) -> list[Finding]:
    """What does not simply hold, worst first."""
    groups: dict[tuple[Outcome, str, str, float], list[Row]] = {}
    for row in rows:
        if row.outcome != "holds":
            groups.setdefault((row.outcome, row.property, row.reason.partition(limits.SAYS)[0], row.bound), []).append(
                row
            )
    found = []
    for (outcome, name, reason, bound), members in groups.items():
        values = [row.value for row in members if row.value is not None]
        found.append(
            Finding(
                outcome,
                name,
                reason,
                bound,
                max(values, default=None),
                tuple(dict.fromkeys(row.case for row in members)),
                tuple(dict.fromkeys(row.technique for row in members)),
            )
        )
    return sorted(found, key=lambda finding: -OUTCOMES.index(finding.outcome))


def markdown(
    environment: Mapping[str, Any], cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]
) -> str:
    lines = [
        "# Stability",
        "",
        "Every technique, with its default settings, on cases that are hard on numbers. Written by "
        "`penumbra stability --out DIR --page docs/stability.md`; what is run, what must hold and from which figure on "
        "is data in `addon/penumbra/stability/cases.py`, what a method may be wrong by, and why, in `limits.py` beside "
        "it. The truth is the exact one (rectangles, polygons) or rays.",
        "",
        _machine(environment),
        "",
        *(f"- {_MARKS[outcome]} {_MEANING[outcome]}: {number} rows" for outcome, number in counts(rows).items()),
        "",
        "| case | " + " | ".join(f"`{technique}`" for technique in techniques) + " |",
        "|---|" + ":-:|" * len(techniques),
    ]
    for case, cells in _cells(cases, techniques, rows):
        lines.append(f"| `{case.id}` | " + " | ".join(_MARKS[cell] if cell else "" for cell in cells) + " |")
    for outcome, title in (
        ("violated", "Violated"),
        ("known_limit", "Known limits"),
        ("bounded", "Bounded"),
    ):
        own = [finding for finding in findings(rows) if finding.outcome == outcome]
        if own:
            lines += [
                "",
                f"## {title}",
                "",
                "| property | techniques | cases | worst | bound | why |",
                "|---|---|---|--:|--:|---|",
            ]
            lines += [
                f"| {f.property} | {_codes(f.techniques)} | {_codes(f.cases)} | {_figure(f.value)} | "
                f"{_figure(f.bound)} | {f.reason} |"
                for f in own
            ]
    lines += ["", "## Cases", "", "| case | what it is | what must hold |", "|---|---|---|"]
    lines += [f"| `{case.id}` | {case.what} | {_asked(case)} |" for case in cases]
    return "\n".join([*lines, ""])


def _cells(
    cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]
) -> Iterator[tuple[Case, list[Outcome | None]]]:
    found: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        found.setdefault((row.case, row.technique), []).append(row)
    for case in cases:
        own = [found.get((case.id, technique), []) for technique in techniques]
        yield case, [worst(entries) if entries else None for entries in own]


def _asked(case: Case) -> str:
    asked = [f"{check.property} ({_figure(check.bound)})" for check in case.checks]
    return ", ".join(asked) if asked else "finite, in 0 to 1"


def _codes(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _machine(environment: Mapping[str, Any]) -> str:
    return f"{environment.get('cpu', '')}, {environment.get('cores', '')} cores, {environment.get('gl_renderer', '')}."


_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; color: #1c1e21; }
table { border-collapse: collapse; } td, th { border: 1px solid #d5d8dc; padding: .2rem .5rem; text-align: left; }
td.holds { color: #2b7a3d; } td.bounded { background: #eef4fb; } td.known_limit { background: #fdf3dc; }
td.violated { background: #f9d9d6; font-weight: bold; } td[class] { text-align: center; } code { font-size: .92em; }
"""


def _html(environment: Mapping[str, Any], cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]) -> str:
    def cell(text: object) -> str:
        return f"<td>{html.escape(str(text))}</td>"

    head = "".join(f"<th>{html.escape(technique)}</th>" for technique in techniques)
    body = "".join(
        f'<tr><td title="{html.escape(case.what)}">{html.escape(case.id)}</td>'
        + "".join(f'<td class="{own}">{_MARKS[own]}</td>' if own else "<td></td>" for own in cells)
        + "</tr>\n"
        for case, cells in _cells(cases, techniques, rows)
    )
    legend = "".join(f"<li>{_MARKS[o]} {_MEANING[o]}: {n} rows</li>" for o, n in counts(rows).items())
    reasons = "".join(
        f"<tr>{cell(f.outcome)}{cell(f.property)}{cell(', '.join(f.techniques))}{cell(', '.join(f.cases))}"
        f"{cell(_figure(f.value))}{cell(_figure(f.bound))}{cell(f.reason)}</tr>\n"
        for f in findings(rows)
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>Stability</title><style>{_STYLE}</style>'
        f"</head><body><h1>Stability</h1><p>{html.escape(_machine(environment))}</p><ul>{legend}</ul>\n"
        f"<table><tr><th>case</th>{head}</tr>\n{body}</table>\n"
        "<h2>What does not simply hold</h2><table><tr><th>outcome</th><th>property</th><th>techniques</th>"
        f"<th>cases</th><th>worst</th><th>bound</th><th>why</th></tr>\n{reasons}</table></body></html>\n"
    )
