#!/usr/bin/env python3
"""The viewport in Blender's window: how fast it follows, where the time goes, what the overlay costs.

    python tests/benchmarks/viewport_bench.py [--views N]

Needs what the tests in Blender's window need (tools/blender_window make, build). Prints what docs/performance.md has;
takes about four minutes on an idle machine of two cores.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("read", "core", "upload", "draw")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--views", type=int, default=40)
    arguments = parser.parse_args()
    measured = run(arguments.views)
    print("960 x 540, courtyard, medians\n")
    print("| technique | after | full pictures/s | whole, ms | export, ms | core, ms | upload, ms | drawing, ms |")
    print("|---|---|---:|---:|---:|---:|---:|---:|")
    for technique, what in dict.fromkeys((row["technique"], row["what"]) for row in measured["times"]):
        rows = [row for row in measured["times"] if (row["technique"], row["what"]) == (technique, what)]
        if what == "orbit":
            print(f"| `{technique}` | orbiting without rest | {rows[0]['pictures']:.1f} shown | | | | | |")
            continue
        whole = median(rows, "seconds")
        read, core, upload, draw = (1e3 * median(rows, part) for part in PARTS)
        if what == "turn":
            read = 0.0  # nothing in the scene changed
        words = {"turn": "a turn of the view", "move": "a move of an object"}[what]
        print(
            f"| `{technique}` | {words} | {1 / whole:.1f} | {1e3 * whole:.1f} | {read:.1f} | {core:.1f} | {upload:.1f} "
            f"| {draw - upload:.1f} |"
        )
    without = measured["without"]["redraw"]
    for name, words in (("with", "two techniques"), ("with_error", "an error with its legend and figures")):
        row = measured[name]
        print(
            f"\nOverlay with {words}: Blender waits {1e3 * row['overlay']:.2f} ms for it per redraw; the whole redraw, "
            f"software OpenGL included, takes {1e3 * row['redraw']:.1f} ms, {1e3 * without:.1f} without; upload of new "
            f"pictures {1e3 * row['upload']:.1f} ms, once."
        )
    return 0


def median(rows: list[dict[str, Any]], part: str) -> float:
    return statistics.median(row[part] for row in rows)


def run(views: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        extension = Path(folder) / "penumbra.zip"
        tool = [sys.executable, ROOT / "tools" / "build_extension", "--python", "3.13", "--without-report"]
        subprocess.run([*tool, "--out", extension], check=True, stdout=subprocess.DEVNULL)
        script = Path(__file__).with_name("viewport_window.py")
        ran = subprocess.run(
            [ROOT / "tools" / "blender_window", "run", script, folder, f"/out/{extension.name}", str(views)],
            env={"PENUMBRA_WINDOW_TIMEOUT": "900"} | os.environ,
            capture_output=True,
            text=True,
        )
        answer = Path(folder) / "times.json"
        if not answer.is_file():
            raise SystemExit(ran.stdout + ran.stderr)
        measured: dict[str, Any] = json.loads(answer.read_text())
        return measured


if __name__ == "__main__":
    sys.exit(main())
