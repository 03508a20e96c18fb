"""Runs `penumbra compare` on real files and keeps the outcome as a table in docs/real-scenes.md.

    python tests/real_scenes.py [--data DIR] [--write docs/real-scenes.md] [FILE ...]

Real files: the Stanford bunny of Debian's glmark2-data, every .blend of Debian's pink-pony-data and assimp-testmodels,
and the meshes in DIR (../shared/data beside the checkout where there is one). Each file gets a process of its own and
a time limit. Exit code 1 if any file ended otherwise than with a report or with one sentence and exit code 2.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("glmark2-data", "pink-pony-data", "assimp-testmodels")
MESHES = (".obj", ".ply", ".stl", ".glb", ".gltf", ".usd", ".usda", ".usdc", ".usdz")
GOOD, BAD_INPUT = 0, 2
LIMIT_S = 600


@dataclass
class Outcome:
    """What became of one file."""

    path: Path
    source: str
    code: int | None = None  # None: the time limit passed
    sentence: str = ""
    seconds: float = 0.0
    triangles: int = 0
    lights: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    penumbra: float | None = None  # share of the compared pixels
    rmse: dict[str, float] = field(default_factory=dict)

    @property
    def as_expected(self) -> bool:
        return self.code == GOOD or (self.code == BAD_INPUT and bool(self.sentence) and "\n" not in self.sentence)


def package_files(package: str) -> list[Path]:
    """The scene files of a Debian package; none if it is not installed."""
    done = subprocess.run(["dpkg", "-L", package], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"{package} is not installed: left out", file=sys.stderr)
        return []
    paths = [Path(line) for line in done.stdout.splitlines()]
    if package == "glmark2-data":
        return sorted(p for p in paths if p.name == "bunny.obj")
    return sorted(p for p in paths if p.suffix == ".blend")


def collect(data: Path | None) -> list[tuple[Path, str]]:
    files = [(path, package) for package in PACKAGES for path in package_files(package)]
    if data is not None:
        meshes = sorted(p for p in data.iterdir() if p.suffix.lower() in MESHES)
        files += [(path, "shared data") for path in meshes]
    return files


def compare(path: Path, source: str, size: str, reference_error: float, limit_s: float) -> Outcome:
    outcome = Outcome(path, source)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report"
        command = [sys.executable, "-m", "penumbra", "compare", str(path), "--out", str(out), "--size", size]
        command += ["--reference-error", str(reference_error), "--no-cache"]
        started = time.monotonic()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
        except subprocess.TimeoutExpired:
            outcome.sentence = f"not done after {limit_s:.0f} s"
            return outcome
        finally:
            outcome.seconds = time.monotonic() - started
        outcome.code = done.returncode
        if done.returncode != GOOD:
            outcome.sentence = done.stderr.strip()
        report = out / "report.json"
        if report.exists():
            read_report(outcome, json.loads(report.read_text(encoding="utf-8"))["scenes"][0])
    return outcome


def read_report(outcome: Outcome, scene: dict[str, Any]) -> None:
    """Figures over all lights of the scene, each light weighted by its compared pixels."""
    outcome.triangles = scene["triangles"]
    outcome.lights = [light["shape"] for light in scene["lights"]]
    outcome.notes = scene.get("notes", [])
    squares: dict[str, float] = {}
    pixels: dict[str, int] = {}
    penumbra = compared = 0
    for light in scene["lights"]:
        records = [record for record in light["records"] if record["status"] == "ok" and not record.get("sweep")]
        for record in records:
            area, name = record["error"]["area"], record["technique"]
            squares[name] = squares.get(name, 0.0) + area["rmse"] ** 2 * area["pixels"]
            pixels[name] = pixels.get(name, 0) + area["pixels"]
        if records:
            area = records[0]["error"]["area"]
            penumbra += area["penumbra_pixels"]
            compared += area["pixels"]
    outcome.penumbra = penumbra / compared if compared else None
    outcome.rmse = {name: math.sqrt(squares[name] / pixels[name]) for name in squares if pixels[name]}


# --------------------------------------------------------------------------------------------------------------- page


def counted(words: Iterable[str]) -> str:
    """sun, 2 point"""
    counts: dict[str, int] = {}
    for word in words:
        counts[word] = counts.get(word, 0) + 1
    return ", ".join(word if count == 1 else f"{count} {word}" for word, count in counts.items())


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def page(outcomes: list[Outcome], size: str, reference_error: float, environment: str) -> str:
    techniques = list(dict.fromkeys(name for outcome in outcomes for name in outcome.rmse))
    good = sum(outcome.code == GOOD for outcome in outcomes)
    refused = sum(outcome.code == BAD_INPUT for outcome in outcomes)
    lines = [
        "# Real scenes",
        "",
        "Files that other people made, each through `penumbra compare` with all techniques at their default settings.",
        "`tests/real_scenes.py` makes this page; run it again to see whether it still holds.",
        "",
        f"{len(outcomes)} files: {good} compared, {refused} refused with one sentence and exit code 2, "
        f"{len(outcomes) - good - refused} otherwise. {size} pixels, reference at a standard error of "
        f"{reference_error:g}. {environment}",
        "",
        "*Penumbra*: share of the compared pixels where the reference is neither lit nor dark. Under a technique's",
        "name: the RMSE of its visibility over all compared pixels of all lights.",
        "",
        "| file | from | triangles | lights | exit code | penumbra | " + " | ".join(techniques) + " | time |",
        "|---|---|---:|---|---:|---:|" + "---:|" * len(techniques) + "---:|",
    ]
    for outcome in outcomes:
        share = "" if outcome.penumbra is None else f"{outcome.penumbra:.1%}"
        figures = [f"{outcome.rmse[name]:.4f}" if name in outcome.rmse else "" for name in techniques]
        code = "time limit" if outcome.code is None else str(outcome.code)
        name, triangles = cell(outcome.path.name), str(outcome.triangles or "")
        cells = [name, outcome.source, triangles, counted(outcome.lights), code, share, *figures]
        lines.append("| " + " | ".join([*cells, f"{outcome.seconds:.0f} s"]) + " |")
    unseen = [outcome.path.name for outcome in outcomes if outcome.code == GOOD and not outcome.rmse]
    if unseen:
        lines += ["", f"Without figures, because no pixel of the picture sees the light: {', '.join(unseen)}."]
    refusals = [outcome for outcome in outcomes if outcome.sentence]
    if refusals:
        lines += ["", "## What was refused, in its own words", ""]
        lines += [f"- `{outcome.path.name}`: {cell(said(outcome))}" for outcome in refusals]
    lines += ["", "## What was left out, placed or approximated", ""]
    for note, names in grouped_notes(outcomes).items():
        count = "1 file" if len(names) == 1 else f"{len(names)} files"
        lines.append(f"- {cell(note)} ({count}: {', '.join(names[:3])}{', ...' if len(names) > 3 else ''})")
    return "\n".join(lines) + "\n"


def said(outcome: Outcome) -> str:
    return outcome.sentence.removeprefix("penumbra: ").replace(str(outcome.path.parent) + "/", "")


def grouped_notes(outcomes: list[Outcome]) -> dict[str, list[str]]:
    """Each remark, without the names it is about, and the files that got it."""
    groups: dict[str, list[str]] = {}
    for outcome in outcomes:
        for note in outcome.notes:
            groups.setdefault(note.split(': "')[0], []).append(outcome.path.name)
    return groups


def environment() -> str:
    program = (
        "import penumbra_core as core; r = core.Renderer().environment; print(r['gl_renderer'], '|', r['threads'])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return ""
    renderer, threads = done.stdout.strip().rsplit("|", 1)
    return f"{renderer.strip()}, {threads.strip()} threads."


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    beside = ROOT.parent / "shared" / "data"
    parser.add_argument("files", nargs="*", type=Path, help="these instead of all")
    parser.add_argument("--data", type=Path, default=beside if beside.is_dir() else None, help="a folder of meshes")
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="write the page; docs/real-scenes.md is the kept one"
    )
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--reference-error", type=float, default=0.005)
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="seconds for one file")
    options = parser.parse_args(arguments)

    files = [(path, "") for path in options.files] or collect(options.data)
    outcomes = []
    for path, source in files:
        outcome = compare(path, source, options.size, options.reference_error, options.limit)
        outcomes.append(outcome)
        state = "ok" if outcome.as_expected else "UNEXPECTED"
        print(f"{state:10} {outcome.code} {outcome.seconds:4.0f} s  {path}  {outcome.sentence}", flush=True)
    if options.write is not None:
        text = page(outcomes, options.size, options.reference_error, environment())
        options.write.write_text(text, encoding="utf-8")
    return 0 if all(outcome.as_expected for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
