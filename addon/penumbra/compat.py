"""Everything in which Blender 4.2, 4.5 and 5.x differ, in one place. No version test stands elsewhere.

Where an attribute tells the versions apart we ask for the attribute, not for the version number.
"""

from __future__ import annotations

from typing import Any

MINIMUM_BLENDER = (4, 2, 0)

_FACTORY_GLTF = "io_scene_gltf2"


def light_strength_factor(light: Any, normalising_area: float) -> float:
    """What multiplies `light.energy`: 2^exposure, and the light's area where it is not normalised (4.5 and newer).

    normalising_area: what Blender divides by when it normalises, see `bridge.normalising_area`.
    """
    factor: float = 2.0 ** float(getattr(light, "exposure", 0.0))
    if not getattr(light, "normalize", True):
        factor *= normalising_area
    return factor


def light_tint(light: Any) -> tuple[float, float, float]:
    """The light's linear colour, times its black-body colour where one is switched on (4.5 and newer)."""
    r, g, b = light.color
    if getattr(light, "use_temperature", False):
        tr, tg, tb = light.temperature_color
        r, g, b = r * tr, g * tg, b * tb
    return float(r), float(g), float(b)


def light_casts_shadow(light: Any) -> bool:
    """Both switches: `use_shadow`, and Cycles' own of 4.2, which later versions merged into it."""
    own = getattr(getattr(light, "cycles", None), "cast_shadow", True)
    return bool(light.use_shadow) and bool(own)


def node_tree(owner: Any) -> Any | None:
    """The node tree of a material, light or world if it is in use.

    Materials and worlds always use theirs from 5.0 on, where asking `use_nodes` is deprecated; lights still choose.
    """
    import bpy

    always = bpy.app.version >= (5, 0, 0) and not isinstance(owner, bpy.types.Light)
    return owner.node_tree if always or owner.use_nodes else None


def panorama_name(camera: Any) -> str:
    """The kind of panorama in words; the property moved from Cycles' settings to the camera in 5.0."""
    kind = getattr(camera, "panorama_type", None) or getattr(getattr(camera, "cycles", None), "panorama_type", "")
    return str(kind).lower().replace("_", " ")


def has_smooth_normals(mesh: Any) -> bool:
    """True if a corner's normal may differ from its face's: any smooth face, or custom normals."""
    return bool(mesh.normals_domain != "FACE" or mesh.has_custom_normals)


def has_soft_falloff(light: Any) -> bool:
    """4.2 and newer: point and spot lights dim as if their centre were farther than it is."""
    return bool(getattr(light, "use_soft_falloff", False))


def too_old(version: tuple[int, ...]) -> bool:
    return tuple(version) < MINIMUM_BLENDER


def ensure_gltf_importer(bpy: Any) -> None:
    """The glTF importer is an add-on written in Python; the others are built in."""
    if "gltf" not in dir(bpy.ops.import_scene):
        import addon_utils

        addon_utils.enable(_FACTORY_GLTF, default_set=False)
