"""Draws the settings of a technique, from the catalogue."""

from __future__ import annotations

from typing import Any

from .. import catalogue


def draw_settings(layout: Any, scene: Any, identifier: str) -> None:
    """All settings of a technique, those that decide its quality first."""
    group = getattr(scene.penumbra.settings, identifier)
    settings = catalogue.technique(identifier)["settings"]
    column = layout.column()
    for setting in sorted(settings, key=lambda setting: not setting["sweep"]):
        column.prop(group, setting["id"])
