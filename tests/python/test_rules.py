"""The page of rules tells of just the rules that the core has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from penumbra import listing

PAGE = Path(__file__).resolve().parents[2] / "docs" / "rules.md"


def test_the_page_has_a_row_for_every_rule_and_no_other(core: Any) -> None:
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in PAGE.read_text(encoding="utf-8").split("## Frames")[0].splitlines()
        if line.startswith("| `")
    ]
    every = len(core.techniques())
    expected = [
        [
            f"`{r['id']}`",
            r["condition"],
            listing.tolerance_text(r["tolerance"]),
            r["stage"],
            listing.users_text(r, every),
        ]
        for r in core.rules()
    ]
    assert [row[:5] for row in rows] == expected, "write it anew: python tests/benchmarks/rules_bench.py"


def test_rules_that_all_techniques_share_are_named_shortly() -> None:
    rule = {"id": "a", "condition": "b", "tolerance": 0.0, "stage": "frame", "techniques": ["x", "y"]}
    assert listing.rules_text([rule], 2) == "a: exact; frame\n  b\n  in all techniques"
    assert listing.rules_text([rule], 3).endswith("in x, y")
    assert listing.users_text(rule | {"techniques": []}, 2) == "the reference"
    assert listing.tolerance_text(0.002) == "changes V by 0.002 at most"
