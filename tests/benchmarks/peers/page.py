"""Table, plot, and the section of docs/performance.md."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from penumbra.report import palette

from . import curves, results
from .plan import OURS
from .results import BLENDER_RATIO, EMBREE_RATIO, SAME, SEEN

Document = dict[str, Any]
BEGIN, END = "<!-- peers: written by tests/benchmarks/peers.py -->", "<!-- end of peers -->"
PICTURE = "images/peers.svg"
LOOKS = {
    "cycles": ("#444444", "-"),
    "cycles_oidn_fast": ("#444444", "--"),
    "cycles_oidn_high": ("#444444", ":"),
    "eevee": ("#999999", "-"),
    "eevee_jitter": ("#999999", "--"),
    "mitsuba": ("#b08020", "-"),
    "embree": ("#c02020", "-"),
}


def section(report: Document) -> str:
    """Markdown between the two marks."""
    parts = [BEGIN, f"Written by `{report['command']}`. {_machine(report)}", f"![error against time]({PICTURE})"]
    for scene in report["scenes"]:
        parts += [f"**{scene['name']}**", _table(scene, SAME)]
    parts += [
        "All against irradiance, which is what a picture shows: our techniques answer with the share of the light's "
        "*area* that is seen, and what that misses is an error here.",
        *(part for scene in report["scenes"] for part in (f"**{scene['name']}**", _table(scene, SEEN))),
        _sync(report),
        END,
    ]
    return "\n\n".join(parts) + "\n"


def _machine(report: Document) -> str:
    environment, settings = report["environment"], report["settings"]
    versions = {name: facts["version"] for scene in report["scenes"] for name, facts in scene["facts"].items()}
    ours: Document = next((scene["facts"][OURS]["environment"] for scene in report["scenes"]), {})
    width, height = settings["size"]
    named = {"cycles": "Blender", "mitsuba": "Mitsuba", "embree": "Embree"}
    said = ", ".join(f"{title} {versions[key]}" for key, title in named.items() if key in versions)
    return (
        f"Machine: {environment['cpu']}, {environment['cores']} cores, {environment['os']}; "
        f"OpenGL by {ours.get('gl_renderer', '?')}; {said}. {width} x {height} pixels, truth to a standard error of "
        f"{settings['reference_error']:g}; `{settings['sweep']}` settings."
    )


def _table(scene: Document, which: str) -> str:
    others = [curve for curve in scene["curves"] if curve["group"] != OURS]
    head = ["RMSE", "best of ours", "ms", *(curve["title"] for curve in others), "of Blender's best", "of Embree"]
    lines = ["| " + " | ".join(head) + " |", "|---:|---|" + "---:|" * (len(head) - 2)]
    for target in scene[f"targets_{which}"]:
        wall, cpu = target["times"]["wall_ms"], target["times"]["cpu_ms"]
        winner = target["wall_ms"]["best_ours"]
        ours = f"`{winner}` ({target['setting']})" if winner else "none"
        cells = [f"{target['error']:g}", ours, _time(wall.get(winner), cpu.get(winner))]
        cells += [_time(wall[each["id"]], cpu[each["id"]]) or _floor(each, which) for each in others]
        cells += [_ratio(target, "over_blender", BLENDER_RATIO), _ratio(target, "over_embree", EMBREE_RATIO)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _time(wall: float | None, cpu: float | None) -> str:
    if wall is None:
        return ""
    return f"{_digits(wall)} ({_digits(cpu)})" if cpu is not None else _digits(wall)


def _digits(milliseconds: float) -> str:
    return f"{milliseconds:.3g}" if milliseconds < 100 else f"{milliseconds:.0f}"


def _floor(curve: Document, which: str) -> str:
    """How near a curve came that does not reach a target."""
    errors = [sample.error for sample in results.samples_of(curve, which, "wall_ms")]
    return f"- (least {min(errors):.3f})" if errors else "not measured"


def _ratio(target: Document, key: str, asked: float) -> str:
    """By the wall, by processor time in brackets; bold where the target that counts is missed."""
    wall, cpu = target["wall_ms"][key], target["cpu_ms"][key]
    if wall is None:
        return "-"
    text = f"{wall:.2g}" + (f" ({cpu:.2g})" if cpu is not None else "")
    missed = target["error"] == results.RATIO_TARGET and wall > asked
    return f"**{text}**" if missed else text


def _sync(report: Document) -> str:
    lines = ["Outside these times: taking the scene over, with the tree for rays where there is one; milliseconds.", ""]
    names = list(dict.fromkeys(name for scene in report["scenes"] for name in scene["facts"]))
    lines += ["| scene | " + " | ".join(names) + " |", "|---|" + "---:|" * len(names)]
    for scene in report["scenes"]:
        cells = [f"{scene['facts'][name]['sync_ms']:.0f}" if name in scene["facts"] else "" for name in names]
        lines.append(f"| {scene['name']} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def put_into_docs(report: Document, docs: Path) -> None:
    """Replaces the section between the marks and the picture that it shows."""
    page = docs / "performance.md"
    text = page.read_text(encoding="utf-8")
    pattern = re.compile(re.escape(BEGIN) + ".*?" + re.escape(END) + "\n?", re.DOTALL)
    if not pattern.search(text):
        raise ValueError(f"{page} has no {BEGIN}")
    page.write_text(pattern.sub(lambda _: section(report), text), encoding="utf-8")
    draw(report, docs / PICTURE)


def draw(report: Document, file: Path) -> None:
    """One panel for each scene, log axes: points, and each curve's staircase."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scenes = report["scenes"]
    columns = min(2, max(1, len(scenes)))
    rows = max(1, -(-len(scenes) // columns))
    style = {"font.size": 9, "svg.fonttype": "none", "svg.hashsalt": "penumbra", "font.family": "sans-serif"}
    with matplotlib.rc_context(style):
        figure = Figure(figsize=(6.2 * columns, 4.6 * rows + 1.0), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        seen: dict[str, Any] = {}
        for axes, scene in zip(grid, scenes, strict=False):
            seen |= _panel(axes, scene)
            axes.set_title(scene["name"], fontsize=10)
        for axes in grid[len(scenes) :]:
            axes.set_axis_off()
        figure.legend(
            list(seen.values()), list(seen), loc="outside lower center", ncols=3 * columns, fontsize=8, frameon=False
        )
        figure.savefig(file, metadata={"Date": None} if file.suffix == ".svg" else None, dpi=110)


def _panel(axes: Any, scene: Document) -> dict[str, Any]:
    handles = {}
    number = 0
    for curve in scene["curves"]:
        samples = results.samples_of(curve, SAME, "wall_ms")
        ours = curve["group"] == OURS
        colour, line = (palette.colour(number), "-") if ours else LOOKS[curve["id"]]
        marker = palette.marker(number) if ours else "."
        number += ours
        if not samples:
            continue
        steps = curves.staircase(samples)
        axes.plot([s.time_ms for s in samples], [s.error for s in samples], marker, color=colour, alpha=0.35, ms=4)
        (handles[curve["title"]],) = axes.plot(
            [s.time_ms for s in steps],
            [s.error for s in steps],
            line,
            marker=marker,
            color=colour,
            ms=4,
            lw=1.5 if ours else 1.1,
        )
    for error in results.TARGETS:
        axes.axhline(error, color="#bbbbbb", lw=0.6, zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("milliseconds, whole call")
    axes.set_ylabel("RMSE of V")
    return handles
