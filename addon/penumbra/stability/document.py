"""The outcome of a run: stability.json, and the same as a page (Markdown, HTML)."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..files import write_bytes
from . import limits
from .cases import EVERY_PICTURE, Case, Check
from .closed_forms import FORMS
from .rows import OUTCOMES, SCHEMA, Outcome, Row, worst

_MARKS: Mapping[Outcome, str] = {"holds": "✓", "bounded": "b", "known_limit": "L", "violated": "✗"}
_MEANING: Mapping[Outcome, str] = {
    "holds": "all that is asked holds",
    "bounded": "off by the method's own error, by no more than its bound",
    "known_limit": "not broken, but outside what the method is for, as the plan says beforehand: a hard shadow, for "
    "example, has no penumbra, and is off wherever the truth has one, by no more than its bound",
    "violated": "a bound is broken: a bug",
}


@dataclass(frozen=True)
class Finding:
    """Rows with one reason, taken together."""

    outcome: Outcome
    property: str
    reason: str
    bound: float
    value: float | None  # the one that comes nearest to its bound
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
    groups: dict[tuple[Outcome, str, str], list[Row]] = {}
    for row in rows:
        if row.outcome != "holds":
            groups.setdefault((row.outcome, row.property, row.reason.partition(limits.SAYS)[0]), []).append(row)
    found = []
    for (outcome, name, reason), members in groups.items():
        nearest = max(members, key=_tightness)
        found.append(
            Finding(
                outcome,
                name,
                reason,
                nearest.bound,
                nearest.value,
                tuple(dict.fromkeys(row.case for row in members)),
                tuple(dict.fromkeys(row.technique for row in members)),
            )
        )
    return sorted(found, key=lambda finding: -OUTCOMES.index(finding.outcome))


def _tightness(row: Row) -> float:
    """Measured over bound; above all where there is no figure."""
    if row.value is None:
        return math.inf
    return row.value / row.bound if row.bound > 0.0 else row.value


def markdown(
    environment: Mapping[str, Any], cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]
) -> str:
    lines = [
        "# Stability",
        "",
        "Every technique, with its default settings, on cases that are hard on numbers. Written by "
        "`penumbra stability --out DIR --page docs/stability.md`; what is run, what must hold and from which figure on "
        "is data in `addon/penumbra/stability/cases.py`, what a method may be wrong by, and why, in `limits.py` beside "
        "it. The truth is the exact one (rectangles, polygons) or rays. No bound comes from a run: each is a formula "
        "of the truth and the geometry of its case, listed under [Bounds](#bounds).",
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
                "| property | techniques | cases | nearest to its bound | why |",
                "|---|---|---|--:|---|",
            ]
            lines += [
                f"| {f.property} | {_codes(f.techniques)} | {_codes(f.cases)} | {_against(f.value, f.bound)} | "
                f"{f.reason} |"
                for f in own
            ]
    lines += _figures(cases, techniques, rows)
    lines += _resources(techniques, rows)
    lines += ["", "## Bounds", "", *_bounds()]
    lines += [
        "",
        "## Cases",
        "",
        f"Of every picture also: {_checks(EVERY_PICTURE)}, and the time and memory of [its row](#time-and-memory): "
        f"{_limits(cases)}.",
        "",
        "| case | what it is | what must hold |",
        "|---|---|---|",
    ]
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
    return _checks(case.checks) if case.checks else "as every picture"


def _checks(checks: Sequence[Check]) -> str:
    return ", ".join(f"{check.property} ({_figure(check.bound)})" for check in checks)


def _limits(cases: Sequence[Case]) -> str:
    usual, *others = sorted({(case.ends_s, case.memory_mb) for case in cases})
    named = [f"`{case.id}`" for case in cases if (case.ends_s, case.memory_mb) in others]
    beyond = f"; {', '.join(named)} {max(case.ends_s for case in cases):g} s" if named else ""
    return f"{usual[0]:g} s and {usual[1]:g} MB for each technique{beyond}"


_PICTURED = ("penumbra", "umbra and light", "picture", "own form")


def _figures(cases: Sequence[Case], techniques: Sequence[str], rows: Sequence[Row]) -> list[str]:
    """What was measured of the pictures that are off, over the bound."""
    found: dict[tuple[str, str], Row] = {}
    for row in rows:
        key = (row.case, row.technique)
        off = row.outcome != "holds" and row.property in _PICTURED
        if off and (key not in found or _tightness(row) > _tightness(found[key])):
            found[key] = row
    lines = [
        "",
        "## Measured over bound",
        "",
        "RMSE over the penumbra, or (e) the share of pixels elsewhere that are wrong, (p) the RMSE of the whole "
        "picture where a bound for the penumbra alone could not fail, (o) the share of pixels that are not what the "
        "method's own formula says, where that of the picture could not fail either. The one nearest to its bound is "
        "shown.",
        "",
        "| case | " + " | ".join(f"`{technique}`" for technique in techniques) + " |",
        "|---|" + "--:|" * len(techniques),
    ]
    marks = {"penumbra": "", "umbra and light": "e ", "picture": "p ", "own form": "o "}
    for case in cases:
        own = [found.get((case.id, technique)) for technique in techniques]
        if any(own):
            cells = [f"{marks[row.property]}{_against(row.value, row.bound)}" if row else "" for row in own]
            lines.append(f"| `{case.id}` | " + " | ".join(cells) + " |")
    return lines


def _resources(techniques: Sequence[str], rows: Sequence[Row]) -> list[str]:
    """The case of each technique that comes nearest to its limits."""
    lines = [
        "",
        "## Time and memory",
        "",
        "The longest and the largest of all cases, and what eight of 24 frames leave behind, each with the bound of "
        "its case. Memory is what is taken at once beyond what the process had in use before.",
        "",
        "| technique | ends, s | memory, MB | leak, MB |",
        "|---|--:|--:|--:|",
    ]
    for technique in techniques:
        cells = []
        for name in ("ends", "memory", "no leak"):
            own = [row for row in rows if row.technique == technique and row.property == name]
            cells.append(_against(max(own, key=_tightness).value, max(own, key=_tightness).bound) if own else "")
        lines.append(f"| `{technique}` | " + " | ".join(cells) + " |")
    return lines


def _bounds() -> list[str]:
    """The formulas in words, from beside their code."""
    lines = [
        "The bound of a case is the figure of the worst picture that the method's own formula allows there, given the "
        "truth: under its light, its centre and lights of other sizes in its place (`closed_forms.py`, `ground.py`). "
        "Where that is no less than for any picture at all, another property is asked.",
        "",
        "| formula | least and greatest V at each pixel |",
        "|---|---|",
    ]
    for name, form in FORMS.items():
        lines.append(f"| {name} | {_one_line(form.__doc__)} |")
    return lines


def _one_line(text: str | None) -> str:
    return " ".join((text or "").split()).replace("|", "\\|")


def _against(value: float | None, bound: float) -> str:
    return f"{_figure(value)} / {_figure(bound)}"


def _codes(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _machine(environment: Mapping[str, Any]) -> str:
    cores, renderer = environment.get("cores", ""), environment.get("gl_renderer", "")
    view = ", view traced by rays" if environment.get("view_by") == "rays" else ""
    return f"{environment.get('cpu', '')}, {cores} cores, {renderer}{view}."


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
