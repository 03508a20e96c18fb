"""What a comparison is to look at, and what it found, as properties of the scene: both are saved with the file.

The rows hold what the table shows and sorts by; `document` holds everything else (docs/decisions/0013).
"""

from __future__ import annotations

from typing import Any

import bpy

from .. import catalogue
from ..properties import with_properties

NAME = "penumbra_comparison"  # bpy.types.Scene's property


@with_properties(
    technique=bpy.props.StringProperty(name="Technique"),
    light=bpy.props.StringProperty(name="Light"),
    light_index=bpy.props.IntProperty(name="Light's number in the comparison"),
    record=bpy.props.IntProperty(name="Number among the light's records"),
    settings=bpy.props.StringProperty(name="Settings", description="As JSON, keys in order"),
    status=bpy.props.StringProperty(name="Status"),
    reason=bpy.props.StringProperty(name="Reason"),
    error=bpy.props.FloatProperty(name="Error", description="Penumbra RMSE against the share of the light's area"),
    time_ms=bpy.props.FloatProperty(name="Time", description="Median of a dynamic frame in milliseconds"),
    outside=bpy.props.BoolProperty(name="Outside its Field of Use"),
    on_front=bpy.props.BoolProperty(name="On the Pareto Front"),
    is_sweep_step=bpy.props.BoolProperty(name="Step of a Sweep"),
    colour=bpy.props.IntProperty(name="Number of the technique's colour"),
    thumbnail=bpy.props.StringProperty(name="Thumbnail"),
)
class PENUMBRA_PG_result(bpy.types.PropertyGroup):  # noqa: N801
    """A row of the table: one technique with its settings at one light. Figures that there are not are -1."""


@with_properties(thumbnail=bpy.props.StringProperty(name="Thumbnail of the reference"))
class PENUMBRA_PG_result_light(bpy.types.PropertyGroup):  # noqa: N801
    """A light that was compared at; its name is the light's."""


def _techniques_group() -> type:
    """A check for each technique, and whether its settings are unfolded; a later technique starts checked."""
    properties: dict[str, Any] = {}
    for info in catalogue.techniques():
        properties[str(info["id"])] = bpy.props.BoolProperty(
            name=str(info["title"]), description=str(info["summary"]).rstrip("."), default=True
        )
        properties[f"{info['id']}_open"] = bpy.props.BoolProperty(
            name=f"Settings of {info['title']}", description="Show the settings that it is compared with", default=False
        )
    made = type("PENUMBRA_PG_compared", (bpy.types.PropertyGroup,), {"__doc__": "Techniques to compare"})
    return with_properties(**properties)(made)


def _comparison_group(techniques: type) -> type:
    made = type("PENUMBRA_PG_comparison", (bpy.types.PropertyGroup,), {"__doc__": "Comparing in Blender"})
    return with_properties(
        techniques=bpy.props.PointerProperty(type=techniques, name="Techniques"),
        lights=bpy.props.EnumProperty(
            name="Lights",
            description="Lights to compare at, each by itself",
            items=[
                ("ALL", "All", "Every light that the viewport shows"),
                ("SELECTED", "Selected", "The selected lights"),
            ],
            default="ALL",
        ),
        view=bpy.props.EnumProperty(
            name="View",
            description="What is looked at while comparing",
            items=[
                ("CAMERA", "Camera", "The frame of the scene's camera"),
                ("VIEW", "This View", "What the 3D viewport shows"),
            ],
            default="CAMERA",
        ),
        scale=bpy.props.IntProperty(
            name="Resolution",
            description="Of the render's resolution, or of the viewport's. Times hold for this size alone",
            subtype="PERCENTAGE", default=50, min=1, max=100, soft_min=10,
        ),
        target=bpy.props.FloatProperty(
            name="Budget",
            description="Error (penumbra RMSE) that the technique may have; the cheapest within it is looked for",
            default=0.05, min=0.0, max=1.0, precision=3, step=1,
        ),
        sweep=bpy.props.EnumProperty(
            name="Sweep",
            description="Compare other values of the settings too, for curves of error against time",
            items=[
                ("off", "Off", "Each technique once, with its settings"),
                ("quick", "Quick", "Also about three values of the setting that decides each one's quality"),
                ("full", "Full", "Also all values of all settings that decide quality; takes long"),
            ],
            default="off",
        ),
        timing_seconds=bpy.props.FloatProperty(
            name="Timing",
            description="Seconds for each technique's times; most end sooner. More makes them surer",
            default=1.0, min=0.05, max=60.0, soft_max=10.0, unit="TIME_ABSOLUTE", subtype="TIME_ABSOLUTE",
        ),
        rows=bpy.props.CollectionProperty(type=PENUMBRA_PG_result, name="Results"),
        active_row=bpy.props.IntProperty(name="Active Result", description="The row that is looked at"),
        result_lights=bpy.props.CollectionProperty(type=PENUMBRA_PG_result_light, name="Compared Lights"),
        shown_light=bpy.props.StringProperty(name="Light", description="The light whose results are listed"),
        sort_by=bpy.props.EnumProperty(
            name="Sort",
            description="Order of the table",
            items=[
                ("ERROR", "Error", "The most accurate first"),
                ("TIME", "Time", "The fastest first"),
                ("NAME", "Name", "By name"),
            ],
            default="ERROR",
        ),
        sort_reverse=bpy.props.BoolProperty(name="Reverse", description="The other way round", default=False),
        show_error=bpy.props.BoolProperty(
            name="Error", description="Thumbnails of the error in false colours, instead of visibility", default=False
        ),
        noise=bpy.props.FloatProperty(name="Standard error of the reference"),
        heading=bpy.props.StringProperty(name="What was compared"),
        key=bpy.props.StringProperty(name="Key of the pictures in the cache"),
        document=bpy.props.StringProperty(name="The report's records, compressed"),
    )(made)  # fmt: skip


_registered: list[type] = []


def group() -> type:
    """The registered class of the scene's property."""
    return _registered[-1]


def register() -> None:
    techniques = _techniques_group()
    for group in (PENUMBRA_PG_result, PENUMBRA_PG_result_light, techniques, _comparison_group(techniques)):
        bpy.utils.register_class(group)
        _registered.append(group)
    setattr(bpy.types.Scene, NAME, bpy.props.PointerProperty(type=_registered[-1], name="Penumbra Comparison"))


def unregister() -> None:
    delattr(bpy.types.Scene, NAME)
    while _registered:
        bpy.utils.unregister_class(_registered.pop())
