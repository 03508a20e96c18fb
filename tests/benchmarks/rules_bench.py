"""What each rule that leaves work out saves: docs/rules.md, written anew.

    python tests/benchmarks/rules_bench.py [--out docs/rules.md] [--size WxH] [--seconds S] [--scenes a,b] ...

For each example, light and technique one interleaved run: the plan as it is, with nothing left out, and with each rule
that fires kept alone. The dynamic frame is measured, the static one (maps kept), and the kept one (nothing changed).
Less of everything, for a first look: --size 160x90 --seconds 0.2.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import textwrap
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import penumbra_core as core
from penumbra import environment, scenes
from penumbra.listing import tolerance_text, users_text

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ("courtyard", "desk", "plaza")
REFERENCE_ERROR = 0.01


@dataclass
class Frame:
    """Medians and their 95 % intervals, in milliseconds."""

    median: float
    low: float
    high: float


@dataclass
class Run:
    """One technique at one light of one scene."""

    scene: str
    light: str
    technique: str
    plan: dict[str, Frame]
    everything: dict[str, Frame]
    alone: dict[str, Frame] = field(default_factory=dict)  # dynamic frame with only this rule kept

    @property
    def where(self) -> str:
        return f"{self.scene}, {self.light}: {self.technique}"


def frames(answer: dict[str, Any]) -> dict[str, Frame]:
    return {
        name: Frame(*(float(answer[name][figure]) for figure in ("median", "low", "high")))
        for name in ("dynamic", "static", "kept")
    }


def rules_fired(plan: list[dict[str, Any]]) -> list[str]:
    return sorted({str(step["rule"]) for step in plan if step["state"] == "left_out"})


def measure(renderer: Any, scene: str, light: int, name: str, technique: str, arguments: argparse.Namespace) -> Run:
    fired = rules_fired(renderer.visibility(light, technique, statistics=False)["plan"])
    kept = [[], ["all"], *([rule] for rule in fired)]
    answers = renderer.measure(
        light,
        [(technique, {})] * len(kept),
        max_seconds=arguments.seconds,
        min_runs=arguments.runs,
        max_runs=max(20, arguments.runs),
        keep_rules=kept,
    )
    run = Run(scene, name, technique, frames(answers[0]), frames(answers[1]))
    run.alone = {rule: frames(answer)["dynamic"] for rule, answer in zip(fired, answers[2:], strict=True)}
    return run


def reference_saving(renderer: Any, light: int) -> tuple[float, float]:
    """Milliseconds of a reference, planned and with every ray."""
    times = [
        float(renderer.reference(light, standard_error=REFERENCE_ERROR, keep_everything=keep)["time_ms"])
        for keep in (False, True)
    ]
    return times[0], times[1]


# ------------------------------------------------------------------------------------------------------------- words


def ms(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def share(part: float, whole: float) -> float:
    return 100.0 * (1.0 - part / whole) if whole > 0 else 0.0


def apart(a: Frame, b: Frame) -> bool:
    """The intervals of two medians do not meet."""
    return a.high < b.low or b.high < a.low


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def rule_rows(runs: list[Run], references: dict[str, tuple[float, float]]) -> list[str]:
    every = len(core.techniques())
    rows = [
        row("rule", "leaves work out where", "tolerance", "of", "in", "largest saving here, of the dynamic frame"),
        "|---|---|---|---|---|---|",
    ]
    for rule in core.rules():
        fired = [run for run in runs if rule["id"] in run.alone]
        told = [run for run in fired if apart(run.alone[rule["id"]], run.plan["dynamic"])]
        gains = {run.where: run.alone[rule["id"]].median - run.plan["dynamic"].median for run in told}
        if rule["id"] == "frame-unchanged":
            saving = "all but the kept frame of the last table"
        elif rule["stage"] == "reference":
            where = max(references, key=lambda name: share(*references[name]), default="")
            saving = f"{where}: {share(*references[where]):.0f} % of its time" if where else "not measured"
        elif rule["stage"] == "export":
            saving = "the examples hold no such instance"
        elif not fired:
            saving = "does not fire at these lights"
        elif not gains or max(gains.values()) <= 0:
            saving = f"fires {len(fired)} times; none that can be told from noise"
        else:
            best = max(told, key=lambda run: share(run.plan["dynamic"].median, run.alone[rule["id"]].median))
            percent = share(best.plan["dynamic"].median, best.alone[rule["id"]].median)
            saving = f"{best.where}: {ms(gains[best.where])} ms, {percent:.0f} %"
        rows.append(
            row(
                f"`{rule['id']}`",
                rule["condition"],
                tolerance_text(rule["tolerance"]),
                rule["stage"],
                users_text(rule, every),
                saving,
            )
        )
    return rows


def frame_rows(runs: list[Run]) -> list[str]:
    rows = [
        row("technique", "all kept, ms", "plan, ms", "saved", "static, ms", "of plan", "kept, ms", "of plan"),
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for run in runs:
        dynamic, whole = run.plan["dynamic"], run.everything["dynamic"]
        saved = f"{share(dynamic.median, whole.median):.0f} %" if apart(dynamic, whole) else "–"
        static, kept = run.plan["static"].median, run.plan["kept"].median
        rows.append(
            row(
                f"`{run.technique}`",
                ms(whole.median),
                ms(dynamic.median),
                saved,
                ms(static),
                f"{-share(static, dynamic.median):+.0f} %",
                ms(kept),
                f"{-share(kept, dynamic.median):+.1f} %",
            )
        )
    plan = sum(run.plan["dynamic"].median for run in runs)
    whole_sum = sum(run.everything["dynamic"].median for run in runs)
    medians = statistics.median(share(r.plan["dynamic"].median, r.everything["dynamic"].median) for r in runs)
    least = min(share(r.plan["kept"].median, r.plan["dynamic"].median) for r in runs)
    rows += [
        "",
        f"Of the dynamic frame the rules save {share(plan, whole_sum):.0f} % over all techniques, {medians:.0f} % in "
        f"the median of the techniques; a second frame of an unchanged scene saves at least {least:.1f} %.",
    ]
    return rows


def page(
    runs: list[Run], references: dict[str, tuple[float, float]], arguments: argparse.Namespace, device: str
) -> str:
    def wrapped(text: str) -> str:
        return textwrap.fill(text, 118, break_on_hyphens=False)

    load = os.getloadavg()[0]
    lines = [
        "# What is left out",
        "",
        wrapped(
            "Every rule that leaves work out, in one table: `penumbra techniques --rules [--json]` prints it from the "
            "core, whose `renderer/rules.cpp` is the one place where rules are listed. For each there is a scene on "
            "which it fires, one on which it must not, and a test that the image is the same with that rule kept and "
            "with everything kept (`--keep-everything`): `tests/cpp/techniques/rules_gl_test.cpp` goes through the "
            "table and fails for a rule without such scenes. How frames are kept: "
            "[decision 18](decisions/0018-kept-frames.md)."
        ),
        "",
        "This page is written by",
        "",
        f"    python tests/benchmarks/rules_bench.py --size {arguments.size[0]}x{arguments.size[1]} "
        f"--scenes {','.join(arguments.scenes)} --seconds {arguments.seconds:g}"
        f"{' --no-reference' if arguments.no_reference else ''}",
        "",
        wrapped(
            f"Machine: {environment.cpu_model()}, {environment.usable_cores()} cores, {device}, "
            f"{environment.operating_system()}; load average {load:.1f} at the end (1 is this program itself). Each "
            "technique's times are taken in turns in one run; "
            "a saving that the 95 % intervals of its two medians do not tell from nothing is a dash or named so."
        ),
        "",
        "## Rules",
        "",
        *rule_rows(runs, references),
        "",
        "## Frames",
        "",
        wrapped(
            "*all kept*: the dynamic frame with no rule at work. *plan*: the dynamic frame as it is made. *static*: "
            "maps are kept and view space alone is made, what a moved camera would cost if the maps still fitted. "
            "*kept*: a second frame of a scene in which nothing changed, whose V is handed over; the first of them is "
            "the cold frame, *plan*. No kept frame enters a Pareto front."
        ),
    ]
    for scene, light in dict.fromkeys((run.scene, run.light) for run in runs):
        lines += ["", f"### {scene}, {light}", ""]
        lines += frame_rows([run for run in runs if (run.scene, run.light) == (scene, light)])
    if references:
        lines += ["", "## The reference", ""]
        lines += [row("light", "every ray, ms", "planned, ms", "saved"), "|---|---:|---:|---:|"]
        for name, (planned, whole) in references.items():
            lines.append(row(name, ms(whole), ms(planned), f"{share(planned, whole):.0f} %"))
        lines += ["", f"To a standard error of {REFERENCE_ERROR:g}, once each."]
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "rules.md")
    parser.add_argument("--size", default="320x180", type=lambda text: tuple(map(int, text.split("x"))))
    parser.add_argument("--scenes", default=",".join(EXAMPLES), type=lambda text: text.split(","))
    parser.add_argument("--techniques", default="", help="ids, default all", type=lambda text: text.split(","))
    parser.add_argument("--seconds", type=float, default=0.4, help="per kind of frame, at most")
    parser.add_argument("--runs", type=int, default=3, help="per kind of frame, at least, if they fit")
    parser.add_argument("--no-reference", action="store_true", help="leave the reference's saving out")
    arguments = parser.parse_args()
    ids = [str(info["id"]) for info in core.techniques()]
    wanted = [name for name in ids if not any(arguments.techniques) or name in arguments.techniques]
    renderer = core.Renderer()
    runs: list[Run] = []
    references: dict[str, tuple[float, float]] = {}
    for scene in arguments.scenes:
        scenes.open_scene(ROOT / "examples" / f"{scene}.blend")
        export = scenes.read(size=arguments.size)
        renderer.set_scene(export.scene)
        for light, name in enumerate(export.lights):
            for technique in wanted:
                if not renderer.supports(light, technique):
                    runs.append(measure(renderer, scene, light, name, technique, arguments))
                    print(runs[-1].where, file=sys.stderr, flush=True)
            if not arguments.no_reference:
                references[f"{scene}, {name}"] = reference_saving(renderer, light)
    arguments.out.write_text(page(runs, references, arguments, renderer.environment["device"]), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
