"""What Penumbra keeps in a .blend file: settings of the scene, and passes of each view layer.

The groups of the techniques' settings are made from the catalogue, so a new technique or setting appears by itself.
No property has an update function: Blender tells its render engines of every change anyway, and the module of 4.2
crashes at exit over them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import bpy

from . import catalogue
from .records import Settings, Value

NO_TECHNIQUE = "shadow_map"  # what a new file starts with: the cheapest


def with_properties(**properties: Any) -> Callable[[type], type]:
    """Gives a class Blender's properties, which Blender looks for among the annotations."""

    def decorate(cls: type) -> type:
        cls.__annotations__ = dict(properties)
        return cls

    return decorate


def technique_items() -> list[tuple[str, str, str]]:
    return [(info["id"], info["title"], info["summary"]) for info in catalogue.techniques()]


def setting_property(setting: dict[str, Any]) -> Any:
    """Blender's property for one setting of a technique."""
    unit = f" ({setting['unit']})" if setting["unit"] and setting["unit"] != "px" else ""
    common: dict[str, Any] = {
        "name": f"{setting['label']}{unit}",
        "description": str(setting["help"]).rstrip("."),
        "default": setting["default"],
    }
    kind = setting["type"]
    if kind == "bool":
        return bpy.props.BoolProperty(**common)
    if kind == "choice":
        if not setting["choices"]:  # a free name
            return bpy.props.StringProperty(**common)
        return bpy.props.EnumProperty(
            items=[(choice, choice.replace("_", " ").capitalize(), "") for choice in setting["choices"]], **common
        )
    if kind == "int":
        subtype = "PIXEL" if setting["unit"] == "px" else "NONE"
        return bpy.props.IntProperty(
            min=int(setting["minimum"]), max=int(setting["maximum"]), subtype=subtype, **common
        )
    return bpy.props.FloatProperty(min=setting["minimum"], max=setting["maximum"], precision=4, **common)


def _technique_group(info: dict[str, Any]) -> type:
    properties = {setting["id"]: setting_property(setting) for setting in info["settings"]}
    made = type(f"PENUMBRA_PG_{info['id']}", (bpy.types.PropertyGroup,), {"__doc__": f"Settings of {info['title']}"})
    return with_properties(**properties)(made)


def _settings_group(groups: dict[str, type]) -> type:
    pointers = {
        identifier: bpy.props.PointerProperty(type=group, name=catalogue.technique(identifier)["title"])
        for identifier, group in groups.items()
    }
    made = type("PENUMBRA_PG_settings", (bpy.types.PropertyGroup,), {"__doc__": "Settings of all techniques"})
    return with_properties(**pointers)(made)


def settings_of(scene: Any, identifier: str) -> Settings:
    """The settings of a technique as the core takes them."""
    group = getattr(scene.penumbra.settings, identifier)
    return {setting["id"]: _value(group, setting) for setting in catalogue.technique(identifier)["settings"]}


def _value(group: Any, setting: dict[str, Any]) -> Value:
    value = getattr(group, setting["id"])
    if setting["type"] != "float":
        return value  # type: ignore[no-any-return]
    return float(f"{value:.7g}")  # Blender keeps 32 bits: 0.1, not 0.10000000149


def set_settings(scene: Any, identifier: str, settings: Settings) -> None:
    """The other way round: what a comparison found best becomes what the scene uses."""
    group = getattr(scene.penumbra.settings, identifier)
    for key, value in settings.items():
        setattr(group, key, value)


def _scene_group(settings: type) -> type:
    made = type("PENUMBRA_PG_scene", (bpy.types.PropertyGroup,), {"__doc__": "How Penumbra renders this scene"})
    return with_properties(
        technique=bpy.props.EnumProperty(
            name="Technique",
            description="The shadow technique that the picture is made with",
            items=technique_items(),
            default=NO_TECHNIQUE,
        ),
        settings=bpy.props.PointerProperty(type=settings),
        pixel_samples=bpy.props.IntProperty(
            name="Pixel Samples",
            description="Pictures per frame, each moved by a part of a pixel, whose mean smooths edges",
            default=4, min=1, max=256, soft_max=32,
        ),
        viewport_scale=bpy.props.EnumProperty(
            name="While Moving",
            description="Resolution of the viewport while something changes; a full picture follows",
            items=[
                ("1", "Full", "Always the full resolution"),
                ("2", "Half", "Half the pixels across and down"),
                ("4", "Quarter", "A quarter of the pixels across and down"),
            ],
            default="2",
        ),
        reference_error=bpy.props.FloatProperty(
            name="Reference Error",
            description="Standard error of the ray-traced truth that errors are measured against",
            default=0.004, min=0.0002, max=0.1, precision=4,
        ),
        keep_everything=bpy.props.BoolProperty(
            name="Leave Nothing Out",
            description="Do all work even where it cannot matter, which must not change the picture",
            default=False,
        ),
    )(made)  # fmt: skip


@with_properties(
    visibility=bpy.props.EnumProperty(
        name="Visibility",
        description="Techniques that deliver a pass with the share of the lights that each point sees",
        items=technique_items(),
        options={"ENUM_FLAG"},
        default=set(),
    ),
    per_light=bpy.props.BoolProperty(
        name="Per Light",
        description="One visibility pass for each light, instead of one with the product of all lights",
        default=False,
    ),
    use_reference=bpy.props.BoolProperty(
        name="Reference",
        description="A pass with the ray-traced truth",
        default=False,
    ),
    use_error=bpy.props.BoolProperty(
        name="Error",
        description="A pass for each technique with the difference between its visibility and the truth",
        default=False,
    ),
)
class PENUMBRA_PG_view_layer(bpy.types.PropertyGroup):  # noqa: N801
    """Which passes Penumbra delivers."""


def _groups() -> Iterator[type]:
    by_technique = {info["id"]: _technique_group(info) for info in catalogue.techniques()}
    yield from by_technique.values()
    settings = _settings_group(by_technique)
    yield settings
    yield _scene_group(settings)
    yield PENUMBRA_PG_view_layer


_registered: list[type] = []


def register() -> None:
    for group in _groups():
        bpy.utils.register_class(group)
        _registered.append(group)
        if group.__name__ == "PENUMBRA_PG_scene":
            bpy.types.Scene.penumbra = bpy.props.PointerProperty(type=group, name="Penumbra")
    bpy.types.ViewLayer.penumbra = bpy.props.PointerProperty(type=PENUMBRA_PG_view_layer, name="Penumbra")


def unregister() -> None:
    del bpy.types.ViewLayer.penumbra
    del bpy.types.Scene.penumbra
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
