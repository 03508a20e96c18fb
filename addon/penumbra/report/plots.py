"""pareto.svg and pareto.png: error against time, log axes; a panel for each light, and for several together."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

from .. import targets
from ..records import Comparison, LightResult, Record
from . import palette

MAX_PANELS = 24  # more cannot be read in one figure; report.html has them all
_FLOOR = 1e-6  # a log axis has no zero


@dataclass(frozen=True, slots=True)
class Drawn:
    svg: bytes
    png: bytes


def pareto(comparison: Comparison) -> Drawn:
    """Every technique's curve (time of a dynamic frame, headline error), its 95 % intervals, and the front."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    panels = _panels(comparison)
    left_out = len(panels) - MAX_PANELS
    panels = panels[:MAX_PANELS]
    columns = min(max(len(panels), 1), 2)
    rows = max(1, -(-len(panels) // columns))
    with matplotlib.rc_context(
        {"font.size": 9, "svg.fonttype": "none", "svg.hashsalt": "penumbra", "font.family": "sans-serif"}
    ):
        figure = Figure(figsize=(6.2 * columns, 4.3 * rows), layout="constrained")
        FigureCanvasAgg(figure)
        numbers = palette.order(comparison)
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, (title, light) in zip(grid, panels, strict=False):
            _panel(axes, light, numbers, comparison.options.get("target_rmse"))
            axes.set_title(title, fontsize=10)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        if not panels:
            grid[0].text(0.5, 0.5, "no technique could be measured", ha="center", transform=grid[0].transAxes)
        if left_out > 0:
            figure.supxlabel(f"and {left_out} more lights: see report.html", fontsize=9)
        svg, png = io.BytesIO(), io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None})
        figure.set_layout_engine("none")  # it has been laid out; doing so again takes as long as drawing
        figure.savefig(png, format="png", dpi=110, pil_kwargs={"compress_level": 3})
    return Drawn(svg.getvalue(), png.getvalue())


def _panels(comparison: Comparison) -> list[tuple[str, LightResult]]:
    """Titles and figures: of all scenes, of each scene's lights together, of each light."""
    found: list[tuple[str, LightResult]] = []
    if comparison.together is not None:
        count = len(comparison.scenes)
        found.append((f"{count} scenes: geometric mean times, largest errors", comparison.together))
    for scene in comparison.scenes:
        if scene.together is not None:
            found.append((f"{scene.name}: all lights in one frame, largest errors", scene.together))
        found += [(f"{scene.name}: {light.name} ({light.shape})", light) for light in scene.lights]
    return [(title, light) for title, light in found if light.comparable()]


def curves(light: LightResult) -> dict[str, list[list[Record]]]:
    """By technique, first its curve (its own Pareto front, from fast to slow), then each record beside it by itself."""
    found: dict[str, list[list[Record]]] = {}
    for technique in dict.fromkeys(light.records[i].technique for i in light.comparable()):
        on_it = targets.curve(light, technique)
        beside = [i for i in light.comparable() if light.records[i].technique == technique and i not in on_it]
        found[technique] = [[light.records[i] for i in on_it], *([light.records[i]] for i in beside)]
    return found


def _panel(axes: Any, light: LightResult, numbers: dict[str, int], target: float | None) -> None:
    usable = [light.records[i] for i in light.comparable()]
    for technique, (curve, *beside) in curves(light).items():
        colour, marker = palette.colour(numbers[technique]), palette.marker(numbers[technique])
        _draw(axes, curve, color=colour, marker=marker, markersize=5, linewidth=1.2, label=curve[0].title)
        for line in beside:  # something of its own is both cheaper and better
            _draw(axes, line, color=colour, marker=marker, markersize=3, linewidth=0.8, alpha=0.4)
    front = sorted((r for r in usable if r.on_pareto_front), key=lambda record: record.time_ms["dynamic"].median)
    if front:
        axes.step(
            [record.time_ms["dynamic"].median for record in front],
            [max(record.headline, _FLOOR) for record in front],
            where="post", color="0.35", linewidth=5, alpha=0.22, solid_capstyle="round", label="Pareto front", zorder=0,
        )  # fmt: skip
    noise = float(light.reference_info.get("standard_error", 0.0))
    if noise > 0:
        axes.axhline(noise, color="0.5", linestyle=":", linewidth=1, label="reference's noise")
    if target:
        axes.axhline(target, color="0.3", linestyle="--", linewidth=1, label="target")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, which="major", alpha=0.3)
    axes.set_xlabel("dynamic frame, ms")
    axes.set_ylabel("penumbra RMSE")
    axes.legend(fontsize=7, framealpha=0.8)


def _draw(axes: Any, line: list[Record], **style: Any) -> None:
    spreads = [record.time_ms["dynamic"] for record in line]
    below = [max(0.0, spread.median - spread.low) for spread in spreads]
    above = [max(0.0, spread.high - spread.median) for spread in spreads]
    errors = [max(record.headline, _FLOOR) for record in line]
    axes.errorbar([spread.median for spread in spreads], errors, xerr=[below, above], capsize=2, **style)
