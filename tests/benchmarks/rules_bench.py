"""What each rule that leaves work out saves: docs/rules.md, written anew.

    python tests/benchmarks/rules_bench.py [--quick] [--out docs/rules.md] [--scenes a,b] [--techniques a,b] ...

For each example, light and technique one interleaved run: the plan as it is, with nothing left out, and with each rule
that fires kept alone. The dynamic frame is measured, the static one (maps kept), and the kept one (nothing changed).
The whole page is written, and nothing in it by hand. --quick: small frames and a tenth of a second for each kind, to
see the form; it writes rules-quick.md unless --out says otherwise.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import textwrap
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import penumbra_core as core
from penumbra import environment, scenes
from penumbra.listing import tolerance_text, users_text

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ("courtyard", "desk", "plaza")
REFERENCE_ERROR = 0.01
ENOUGH_RUNS = 6  # least and largest of so many hold the median with 97 %
DEFAULTS = {"size": (320, 180), "seconds": 0.25, "runs": 3}
QUICK = {"size": (160, 90), "seconds": 0.1, "runs": 2}
# How rules are proved that no two plans of one frame can show; all others by rules_gl_test.cpp's own table.
PROVED_APART = {
    "light-without-shadow": "is in that table, but cannot be kept: that a light throws no shadow is the artist's wish, "
    "and V is 1 with `--keep-everything` too",
    "instance-without-effect": "works where the scene is sent to the device, before any plan, and cannot be kept; "
    "`AnInstanceThatNobodySeesAndThatCastsNothingIsNotSent` of the same file compares the images with those of the "
    "scene without the instance, and sends it where it is seen or casts",
    "frame-unchanged": "works only where a caller asks for it (`reuse`); `kept_frames_gl_test.cpp` compares the frame "
    "that is handed over with one made anew, for every technique, and changes all that counts",
    "reference-pixel-decided": "works in the reference, which has no plan; "
    "`TheReferenceLeavesOutOnlyRaysThatDecideNothing` of the same file compares it with every ray by the standard "
    "errors that both tell, 4 of them for 99.9 % of the pixels, and has a scene of penumbrae where none is left out",
    "device-without-depth-bounds": "depends on the device and not on the scene; the plan of `hybrid` that asks for "
    "depth bounds is looked at in `hybrid_gl_test.cpp`, on whichever device the tests run",
}


@dataclass
class Frame:
    """Medians and their 95 % intervals, in milliseconds."""

    median: float
    low: float
    high: float
    runs: int


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
        name: Frame(float(of["median"]), float(of["low"]), float(of["high"]), int(of["runs"]))
        for name, of in answer.items()
        if name in ("dynamic", "static", "kept")
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
    """The intervals of two medians do not meet. Those of a few runs do not mean much: then more is asked."""
    few = min(a.runs, b.runs) < ENOUGH_RUNS
    alike = max(a.median, b.median) < 1.5 * min(a.median, b.median)
    return (a.high < b.low or b.high < a.low) and not (few and alike)


def gain(run: Run, rule: str) -> float:
    """Milliseconds of the dynamic frame that the rule saves; negative: that it costs."""
    return run.alone[rule].median - run.plan["dynamic"].median


def largest(runs: list[Run], rule: str) -> str:
    """The largest saving, or cost, of the runs given."""
    if not runs:
        return "–"

    def percent(run: Run) -> float:
        return abs(share(run.plan["dynamic"].median, run.alone[rule].median))

    best = max(runs, key=percent)
    return f"{best.where}: {ms(abs(gain(best, rule)))} ms, {percent(best):.0f} %"


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def rule_rows(runs: list[Run], references: dict[str, tuple[float, float]]) -> list[str]:
    every = len(core.techniques())
    rows = [
        row(
            "rule",
            "leaves work out where",
            "tolerance",
            "of",
            "in",
            "largest saving here, of the dynamic frame",
            "largest cost here",
        ),
        "|---|---|---|---|---|---|---|",
    ]
    for rule in core.rules():
        fired = [run for run in runs if rule["id"] in run.alone]
        told = [run for run in fired if apart(run.alone[rule["id"]], run.plan["dynamic"])]
        paying = [run for run in told if gain(run, rule["id"]) > 0]
        costing = [run for run in told if gain(run, rule["id"]) < 0]
        if rule["id"] == "frame-unchanged":
            saving = "all but the kept frame of the last table"
        elif rule["stage"] == "reference":
            where = max(references, key=lambda name: share(*references[name]), default="")
            saving = f"{where}: {share(*references[where]):.0f} % of its time" if where else "not measured"
        elif rule["stage"] == "export":
            saving = "the examples hold no such instance"
        elif not fired:
            saving = "does not fire at these lights"
        elif not paying:
            saving = f"fires {len(fired)} times; none that can be told from noise"
        else:
            saving = largest(paying, rule["id"])
        rows.append(
            row(
                f"`{rule['id']}`",
                rule["condition"],
                tolerance_text(rule["tolerance"]),
                rule["stage"],
                users_text(rule, every),
                saving,
                largest(costing, rule["id"]),
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


def scene_rows(runs: list[Run]) -> list[str]:
    """A frame of a scene makes V for each of its lights."""
    rows = [
        row("scene", "lights", "all kept, ms", "plan, ms", "saved", "saved, median technique", "kept frame saves"),
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for scene in dict.fromkeys(run.scene for run in runs):
        own = [run for run in runs if run.scene == scene]
        lights = list(dict.fromkeys(run.light for run in own))
        frames: dict[str, list[float]] = {}  # of a technique that serves all lights: plan, all kept, kept frame
        for technique in dict.fromkeys(run.technique for run in own):
            of_it = [run for run in own if run.technique == technique]
            if len(of_it) == len(lights):
                frames[technique] = [
                    sum(run.plan["dynamic"].median for run in of_it),
                    sum(run.everything["dynamic"].median for run in of_it),
                    sum(run.plan["kept"].median for run in of_it),
                ]
        if not frames:
            continue
        plan, whole, _ = (sum(column) for column in zip(*frames.values(), strict=True))
        median = statistics.median(share(of_plan, of_all) for of_plan, of_all, _ in frames.values())
        least = min(share(kept, of_plan) for of_plan, _, kept in frames.values())
        rows.append(
            row(
                f"`{scene}`",
                ", ".join(lights),
                ms(whole),
                ms(plan),
                f"{share(plan, whole):.0f} %",
                f"{median:.0f} %",
                f"{least:.1f} % at least",
            )
        )
    return rows


def command(arguments: argparse.Namespace) -> str:
    """What writes the page again: all that is not by default."""
    words = ["python tests/benchmarks/rules_bench.py"]
    words += ["--quick"] if arguments.quick else []
    usual = QUICK if arguments.quick else DEFAULTS
    if arguments.size != usual["size"]:
        words.append(f"--size {arguments.size[0]}x{arguments.size[1]}")
    if arguments.seconds != usual["seconds"]:
        words.append(f"--seconds {arguments.seconds:g}")
    if arguments.runs != usual["runs"]:
        words.append(f"--runs {arguments.runs}")
    if tuple(arguments.scenes) != EXAMPLES:
        words.append(f"--scenes {','.join(arguments.scenes)}")
    if any(arguments.techniques):
        words.append(f"--techniques {','.join(arguments.techniques)}")
    if arguments.no_reference:
        words.append("--no-reference")
    return " ".join(words)


def page(
    runs: list[Run],
    references: dict[str, tuple[float, float]],
    arguments: argparse.Namespace,
    device: str,
    minutes: float,
) -> str:
    def wrapped(text: str) -> str:
        return textwrap.fill(text, 118, break_on_hyphens=False)

    load = os.getloadavg()[0]
    lines = [
        "# What is left out",
        "",
        wrapped(
            "Every rule that leaves work out, in one table: `penumbra techniques --rules [--json]` prints it from the "
            "core, whose `renderer/rules.cpp` is the one place where rules are listed. "
            "`tests/cpp/techniques/rules_gl_test.cpp` goes through the table: each rule has a scene on which it fires "
            "and one on which it must not, and the image is the same with that rule kept and with everything kept "
            "(`--keep-everything`); a rule without such scenes fails. "
            f"{len(PROVED_APART)} of the {len(core.rules())} are otherwise, as is told below the table. How frames are "
            "kept: [decision 18](decisions/0018-kept-frames.md)."
        ),
        "",
        "This page is written by",
        "",
        f"    {command(arguments)}",
        "",
        wrapped(
            f"Machine: {environment.cpu_model()}, {environment.usable_cores()} cores, {device}, "
            f"{environment.operating_system()}; {arguments.size[0]} x {arguments.size[1]} pixels; load average "
            f"{load:.1f} at the end (1 is this program itself), after {minutes:.0f} minutes. Each technique's times "
            "are taken in turns in one run; a saving, or a cost, that the 95 % intervals of its two medians do not "
            "tell from nothing is a dash or named so, and so is one of less than a third where there are fewer than "
            f"{ENOUGH_RUNS} runs, which make no such interval."
        ),
        "",
        "## Rules",
        "",
        *rule_rows(runs, references),
        "",
        "Proved otherwise than by the table of `rules_gl_test.cpp`:",
        "",
        *(
            textwrap.fill(f"- `{rule}` {words}.", 118, subsequent_indent="  ", break_on_hyphens=False)
            for rule, words in PROVED_APART.items()
        ),
        "",
        "## Frames",
        "",
        wrapped(
            "*all kept*: the dynamic frame with no rule at work. *plan*: the dynamic frame as it is made. *static*: "
            "maps are kept and view space alone is made, what a moved camera would cost if the maps still fitted. "
            "*kept*: a second frame of a scene in which nothing changed, whose V is handed over; the first of them is "
            "the cold frame, *plan*. No kept frame enters a Pareto front."
        ),
        "",
        "A frame of a scene makes V for each light; here they are added up, over techniques that serve every light:",
        "",
        *scene_rows(runs),
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
    parser.add_argument("--quick", action="store_true", help="the form, with figures that are worth little")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), help="default 320x180")
    parser.add_argument("--scenes", default=",".join(EXAMPLES), type=lambda text: text.split(","))
    parser.add_argument("--techniques", default="", help="ids, default all", type=lambda text: text.split(","))
    parser.add_argument("--seconds", type=float, help="per kind of frame, at most; default 0.25")
    parser.add_argument("--runs", type=int, help="per kind of frame, at least, if they fit; default 3")
    parser.add_argument("--no-reference", action="store_true", help="leave the reference's saving out")
    arguments = parser.parse_args()
    for name, value in (QUICK if arguments.quick else DEFAULTS).items():
        if getattr(arguments, name) is None:
            setattr(arguments, name, value)
    if arguments.out is None:
        arguments.out = ROOT / "docs" / "rules.md" if not arguments.quick else Path("rules-quick.md")
    started = time.monotonic()
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
    minutes = (time.monotonic() - started) / 60.0
    text = page(runs, references, arguments, renderer.environment["device"], minutes)
    arguments.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
