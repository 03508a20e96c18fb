"""report.html: one file that opens offline; the template, style and script lie beside this module."""

from __future__ import annotations

import base64
import functools
import json
import math
from dataclasses import asdict, dataclass
from importlib import resources
from typing import Any

from .. import colours, verdict
from ..files import slug
from ..records import PART_FIELDS, Comparison, LightResult, Reach, Record, settings_text
from . import palette
from .pictures import EmbeddedLight, EmbeddedScene

PART_NAMES = {
    "noise": "noise",
    "leak": "leak",
    "over_darkening": "over-darkening",
    "bias": "bias",
    "aliasing": "aliasing",
}


@dataclass(slots=True)
class ShownScene:
    slug: str
    embedded: EmbeddedScene


def page(comparison: Comparison, shown: list[ShownScene], plot_png: bytes) -> str:
    """The whole page as text."""
    numbers = palette.order(comparison)
    scenes: list[dict[str, Any]] = []
    data: list[dict[str, Any]] = []
    for scene, pixels in zip(comparison.scenes, shown, strict=True):
        lights = []
        for index, (light, embedded) in enumerate(zip(scene.lights, pixels.embedded.lights, strict=True)):
            key = f"{pixels.slug}-{index}-{slug(light.name)}"
            entry = {"key": key, "light": light, "rows": _rows(light, numbers), "cards": _cards(light)}
            lights.append(entry | {"timing": verdict.timing_sentence(light)})
            data.append(_light_data(key, scene.size, light, embedded, numbers))
        together = _together(f"{pixels.slug}-together", scene.together, numbers, data)
        scenes.append({"slug": pixels.slug, "scene": scene, "lights": lights, "together": together})
    everything = _together("all-scenes", comparison.together, numbers, data)
    techniques = {r.technique: r.title for s in comparison.scenes for light in s.lights for r in light.records}
    text: str = _template().render(
        comparison=comparison,
        environment=comparison.environment,
        options=comparison.options,
        failures=comparison.failures,
        scenes=scenes,
        together=everything,
        targets=comparison.targets,
        techniques=techniques,
        means_of={mean.technique for target in comparison.targets for mean in target.means if mean.scenes},
        colours={technique: palette.colour(number) for technique, number in numbers.items()},
        style=style(),
        script=_text("report.js"),
        data=_script_safe(
            {
                "albedo": {shown_scene.slug: shown_scene.embedded.albedo for shown_scene in shown},
                "sceneOf": {light["key"]: scene["slug"] for scene in scenes for light in scene["lights"]},
                "lights": data,
                "target": comparison.options.get("target_rmse"),
                "inferno": base64.b64encode(colours.table("inferno").tobytes()).decode(),
                "signed": base64.b64encode(colours.table("RdBu_r").tobytes()).decode(),
            }
        ),
        plot=base64.b64encode(plot_png).decode(),
        part_fields=PART_FIELDS,
        part_names=PART_NAMES,
        budget_name=verdict.error_name,
        reach_table=_reach_table,
    )
    return text


def _together(
    key: str, light: LightResult | None, numbers: dict[str, int], data: list[dict[str, Any]]
) -> dict[str, Any] | None:
    """Several lights' figures, without pictures; the script gets theirs into `data`."""
    if light is None:
        return None
    data.append(_light_data(key, (0, 0), light, EmbeddedLight(), numbers))
    return {"key": key, "light": light}


def _reach_table(light: LightResult) -> dict[str, Any]:
    """A row per technique with what it says of each target, who gets furthest first; and who reaches none."""
    by_name: dict[str, list[Reach]] = {}
    for target in light.targets:
        for reach in target.reaches:
            by_name.setdefault(reach.technique, []).append(reach)

    def rank(row: list[Reach]) -> tuple[int, float]:
        times = [reach.time_ms for reach in row if reach.time_ms is not None]
        return -len(times), times[-1] if times else row[0].closest or 0.0

    rows = sorted(by_name.values(), key=rank)
    return {
        "rows": [row for row in rows if row[0].time_ms is not None],
        "never": [row[0] for row in rows if row[0].time_ms is None],
    }


def _cards(light: LightResult) -> list[dict[str, Any]]:
    cards = []
    for budget in light.budgets:
        record = light.records[budget.record] if budget.record is not None else None
        ties = [light.records[i].label() for i in budget.ties]
        cards.append({"error": budget.error, "record": record, "ties": ties})
    return cards


def _rows(light: LightResult, numbers: dict[str, int]) -> list[dict[str, Any]]:
    """One row per record, with what the template would otherwise have to compute."""
    largest = max((r.area["rmse"] for r in light.records if r.status == "ok" and r.area), default=0.0)
    rows = []
    for i, record in enumerate(light.records):
        row: dict[str, Any] = {
            "index": i,
            "record": record,
            "colour": palette.colour(numbers[record.technique]),
            "settings": settings_text(record.settings),
        }
        if record.status == "ok" and record.area is not None:
            total = sum(record.area["parts"].values())
            length = record.area["rmse"] / largest if largest > 0 else 0.0
            row["parts"] = [
                {"name": name, "share": record.area["parts"][name] / total if total > 0 else 0.0}
                for name in PART_FIELDS
            ]
            row["length"] = length
            row["saved"] = saved_text(record)
            row["step_total_ms"] = sum(step.time_ms for step in record.plan if step.state == "run")
        rows.append(row)
    return rows


def saved_text(record: Record) -> str:
    """What leaving work out saved of a dynamic frame, in words; empty if it was not measured."""
    saved = record.saved_ms()
    if saved is None:
        return ""
    whole = record.everything_ms["dynamic"]
    plan = record.time_ms["dynamic"]
    if plan.high >= whole.low and whole.high >= plan.low:
        return f"no saving to be told from noise in {verdict.milliseconds(whole.median)}"
    verb = "saves" if saved > 0 else "costs"
    share = abs(saved) / whole.median if whole.median > 0 else 0.0
    return f"{verb} {verdict.milliseconds(abs(saved))} of {verdict.milliseconds(whole.median)}, {100.0 * share:.0f} %"


def _light_data(
    key: str, size: tuple[int, int], light: LightResult, pixels: EmbeddedLight, numbers: dict[str, int]
) -> dict[str, Any]:
    """What the script needs of one light."""
    return {
        "key": key,
        "width": size[0],
        "height": size[1],
        "base": pixels.base,
        "baseScale": pixels.base_scale,
        "ambient": pixels.ambient,
        "area": pixels.area,
        "irradiance": pixels.irradiance,
        "noise": light.reference_info.get("standard_error", 0.0),
        "records": [
            _record_data(i, record, pixels.records.get(i, ""), numbers[record.technique])
            for i, record in enumerate(light.records)
            if record.status == "ok"
        ],
    }


def _record_data(index: int, record: Record, picture: str, number: int) -> dict[str, Any]:
    assert record.area is not None and record.irradiance is not None
    keys = ("rmse", "penumbra_rmse", "leak", "over_darkening", "penumbra_pixels")
    return {
        "index": index,
        "technique": record.technique,
        "title": record.title,
        "label": record.label(),
        "settings": settings_text(record.settings),
        "sweep": record.sweep,
        "sweepValues": record.settings,
        "picture": picture,
        "colour": palette.colour(number),
        "marker": number % len(palette.MARKERS),
        "area": {name: record.area.get(name, 0) for name in keys},
        "irradiance": {name: record.irradiance.get(name, 0) for name in keys},
        "flip": record.flip,
        "time": {name: asdict(spread) for name, spread in record.time_ms.items()},
    }


def _script_safe(value: Any) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _text(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def style() -> str:
    """The look of every page that Penumbra writes."""
    return _text("report.css")


@functools.cache
def _template() -> Any:
    return template(_text("report.html.j2"))


def template(text: str) -> Any:
    """A Jinja template with our filters; names are escaped, and unknown ones are errors."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters.update(error=format_error, ms=verdict.milliseconds, bytes=format_bytes, percent=format_percent)
    environment.filters["settings"] = settings_text
    return environment.from_string(text)


def format_error(value: float | None) -> str:
    """Three significant digits, no exponent above 1e-5; a true zero is 0."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    return f"{value:.1e}" if abs(value) < 1e-5 else f"{float(f'{value:.3g}'):.{_decimals(value)}f}"


def _decimals(value: float) -> int:
    return max(0, min(7, 2 - math.floor(math.log10(abs(value)))))


def format_percent(share: float) -> str:
    return f"{share:.0%}" if share >= 0.095 or share == 0 else f"{share:.1%}"


def format_bytes(value: float) -> str:
    for unit in ("B", "KiB", "MiB", "GiB"):
        if value < 1024 or unit == "GiB":
            return f"{value:.0f} {unit}" if unit == "B" or value >= 100 else f"{value:.1f} {unit}"
        value /= 1024
    return ""
