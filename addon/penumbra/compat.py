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

    Materials and worlds always use theirs from 5.0 on, lights from 5.2 on; to ask `use_nodes` is deprecated then.
    """
    import bpy

    always = bpy.app.version >= ((5, 2, 0) if isinstance(owner, bpy.types.Light) else (5, 0, 0))
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


# --- the compositor: a tree of the scene's own up to 4.5, a node group from 5.0 on ------------------------------------


def compositor_tree(scene: Any, *, make: bool) -> Any | None:
    """The scene's compositing nodes, in use; None where there are none and `make` is off."""
    import bpy

    if hasattr(scene, "compositing_node_group"):
        if scene.compositing_node_group is None and make:
            tree = bpy.data.node_groups.new("Compositor", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            scene.compositing_node_group = tree
        return scene.compositing_node_group
    if make and not scene.use_nodes:
        scene.use_nodes = True
    return scene.node_tree if scene.use_nodes else None


def compositor_output(tree: Any) -> Any:
    """The socket that takes the render's final picture; its node is made where there is none."""
    import bpy

    own = "CompositorNodeComposite" if hasattr(bpy.types, "CompositorNodeComposite") else "NodeGroupOutput"
    found = next((node for node in tree.nodes if node.bl_idname == own), None)
    if found is None:
        found = tree.nodes.new(own)
    return found.inputs[0]


def compositor_node(tree: Any, kind: str) -> Any:
    """A node that was the compositor's own up to 4.5 and is shared with shaders from 5.0 on: "Math", "SeparateXYZ" or
    "ValToRGB".
    """
    import bpy

    own = f"CompositorNode{kind}"
    return tree.nodes.new(own if hasattr(bpy.types, own) else f"ShaderNode{kind}")


def compositor_across(tree: Any, picture: Any) -> Any:
    """A socket with the place in the picture from 0 at its left to 1 at its right edge.

    picture: a socket whose picture has the size that counts (4.5 and newer)
    """
    import bpy

    if hasattr(bpy.types, "CompositorNodeImageCoordinates"):
        places = tree.nodes.new("CompositorNodeImageCoordinates")
        tree.links.new(picture, places.inputs[0])
        parts = compositor_node(tree, "SeparateXYZ")
        tree.links.new(places.outputs["Normalized"], parts.inputs[0])
        return parts.outputs["X"]
    # A blend texture runs over the render's size. It gives the left edge of a pixel, where 4.5 gives its middle.
    name = "Penumbra Across"
    texture = bpy.data.textures.get(name) or bpy.data.textures.new(name, "BLEND")
    node = tree.nodes.new("CompositorNodeTexture")
    node.texture = texture
    return node.outputs["Value"]


# --- viewport --------------------------------------------------------------------------------------------------------


def texture_to_srgb() -> dict[str, bool]:
    """What draw_texture_2d() needs to show linear pixels in a drawing handler.

    Up to 4.5 the viewport's own buffer encodes what is drawn as sRGB; from 5.0 on the shader has to.
    """
    import bpy

    return {"is_scene_linear_with_rec709_srgb_target": True} if bpy.app.version >= (5, 0, 0) else {}
