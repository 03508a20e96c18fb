"""pareto.svg and pareto.png: error against time, log axes, one panel per light."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

from .. import verdict
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

    panels = [(scene, light) for scene in comparison.scenes for light in scene.lights if verdict.comparable(light)]
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
        for axes, (scene, light) in zip(grid, panels, strict=False):
            _panel(axes, light, numbers)
            axes.set_title(f"{scene.name}: {light.name} ({light.shape})", fontsize=10)
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


def curves(light: LightResult) -> dict[str, list[list[Record]]]:
    """By technique, the records of each curve in the order of the swept value; what was asked for is on all."""
    found: dict[str, list[list[Record]]] = {}
    usable = [light.records[i] for i in verdict.comparable(light)]
    for base in (record for record in usable if not record.is_sweep_step):
        steps: dict[str, list[Record]] = {}
        for record in usable:
            if record.technique == base.technique and record.sweep:
                steps.setdefault(str(record.sweep["setting"]), []).append(record)
        lines = []
        for setting, members in steps.items():
            values = [*members, base]
            numeric = all(isinstance(record.settings.get(setting), (int, float)) for record in values)
            if numeric:
                values.sort(key=lambda record: float(record.settings[setting]))
            lines.append(values)
        found[base.technique] = lines or [[base]]
    return found


def _panel(axes: Any, light: LightResult, numbers: dict[str, int]) -> None:
    usable = [light.records[i] for i in verdict.comparable(light)]
    for technique, lines in curves(light).items():
        colour, marker = palette.colour(numbers[technique]), palette.marker(numbers[technique])
        for k, line in enumerate(lines):
            x = [record.time_ms["dynamic"].median for record in line]
            y = [max(record.headline, _FLOOR) for record in line]
            spread = [
                [max(0.0, t - record.time_ms["dynamic"].low) for t, record in zip(x, line, strict=True)],
                [max(0.0, record.time_ms["dynamic"].high - t) for t, record in zip(x, line, strict=True)],
            ]
            axes.errorbar(
                x, y, xerr=spread, color=colour, marker=marker, markersize=5, linewidth=1.2, capsize=2,
                label=line[0].title if k == 0 else None,
            )  # fmt: skip
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
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, which="major", alpha=0.3)
    axes.set_xlabel("dynamic frame, ms")
    axes.set_ylabel("penumbra RMSE")
    axes.legend(fontsize=7, framealpha=0.8)
