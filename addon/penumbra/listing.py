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


def tolerance_text(tolerance: float) -> str:
    return "exact" if tolerance == 0 else f"changes V by {tolerance:g} at most"


def users_text(rule: dict[str, Any], every: int) -> str:
    """The techniques that a rule can fire in; `every`: how many there are."""
    users = rule["techniques"]
    return "all techniques" if len(users) == every else ", ".join(users) or "the reference"


def rules_text(rules: list[dict[str, Any]], every: int) -> str:
    """What may be left out when, by how much V may then change, what of a frame it saves, and where."""
    blocks = []
    for rule in rules:
        lines = [f"{rule['id']}: {tolerance_text(rule['tolerance'])}; {rule['stage']}"]
        for text in (rule["condition"], f"in {users_text(rule, every)}"):
            lines += textwrap.wrap(str(text), 100, initial_indent="  ", subsequent_indent="  ")
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)
