"""Turns a comparison into files: report.html, report.json, results.csv, pareto.svg/png, EXR and PNG images.

Every file is written whole or not at all, images first and report.html last, so that what a killed run leaves behind
is complete files, and a report.html never shows more than there is.
"""

from __future__ import annotations

import json
from pathlib import Path

from ..files import unique_slug, write_bytes
from ..records import Comparison, SceneResult, to_json
from . import html, pictures, plots, table


class ReportWriter:
    """Collects scenes one by one, so that only one scene's images are in memory at a time."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._shown: list[html.ShownScene] = []

    def add_scene(self, scene: SceneResult) -> None:
        """Writes the scene's images, notes their paths in its records, and lets go of the pixels."""
        slug = unique_slug(scene.name, [shown.slug for shown in self._shown])
        pictures.write(self._folder, slug, scene)
        self._shown.append(html.ShownScene(slug, pictures.embed(scene)))
        pictures.drop_pixels(scene)

    def finish(self, comparison: Comparison) -> Path:
        """Writes everything that speaks of all scenes. @return the path of report.html"""
        self._folder.mkdir(parents=True, exist_ok=True)
        drawn = plots.pareto(comparison)
        page = html.page(comparison, self._shown, drawn.png)
        document = json.dumps(to_json(comparison), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
        write_bytes(self._folder / "pareto.svg", drawn.svg)
        write_bytes(self._folder / "pareto.png", drawn.png)
        write_bytes(self._folder / "results.csv", table.csv_text(comparison).encode())
        write_bytes(self._folder / "report.json", document.encode())
        target = self._folder / "report.html"
        write_bytes(target, page.encode())
        return target


__all__ = ["ReportWriter"]
