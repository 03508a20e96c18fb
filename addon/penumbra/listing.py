"""Techniques and rules as text for people."""

from __future__ import annotations

import textwrap
from typing import Any


def techniques_text(infos: list[dict[str, Any]]) -> str:
    """Id, title, lights, and each setting with its range and default."""
    blocks = []
    for info in infos:
        lines = [f"{info['id']}: {info['title']}"]
        lines += textwrap.wrap(str(info["summary"]), 100, initial_indent="  ", subsequent_indent="  ")
        lines.append(f"  lights: {', '.join(info['lights'])}")
        lines += [f"  {_setting(info['id'], setting)}" for setting in info["settings"]]
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)


def _setting(technique: str, setting: dict[str, Any]) -> str:
    default = setting["default"]
    if setting["type"] == "bool":
        allowed, default = "on, off", "on" if default else "off"
    elif setting["type"] == "choice":
        allowed = ", ".join(setting["choices"]) or "any name"
    else:
        allowed = f"{setting['minimum']:g} to {setting['maximum']:g}"
        default = f"{default:g}" if isinstance(default, float) else default
    unit = f" {setting['unit']}" if setting["unit"] else ""
    sweep = ", ".join(str(value) for value in setting["sweep"])
    tried = f" A sweep tries {sweep}." if sweep else ""
    return f"{technique}.{setting['id']}={default}  ({allowed}{unit}) {setting['help']}{tried}"


def rules_text(rules: list[dict[str, Any]]) -> str:
    """What may be left out when, and by how much V may then change."""
    width = max((len(str(rule["id"])) for rule in rules), default=0)
    lines = []
    for rule in rules:
        tolerance = "exact" if rule["tolerance"] == 0 else f"changes V by {rule['tolerance']:g} at most"
        lines.append(f"{rule['id']:<{width}}  {rule['condition']} ({tolerance})")
    return "\n".join(lines)
