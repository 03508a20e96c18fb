"""The compositor: one operator that wires Penumbra's passes into a group with wipe, difference and false colours."""

from __future__ import annotations

from typing import Any

import bpy

from . import catalogue, colours, compat, images, passes
from .engine import ENGINE
from .properties import technique_items, with_properties

GROUP = "Penumbra Compare"
_VERSION = 1  # of the group; raised when it is made in another way
_MARK = "penumbra_compare"
_SPACING = 190.0
OUTPUTS = ("Wipe", "Difference", "False Colour")


def _linear(code: int) -> float:
    x = code / 255.0
    return x / 12.92 if x <= 0.04045 else float(((x + 0.055) / 1.055) ** 2.4)


class _Builder:
    """Puts nodes into a tree, from left to right."""

    def __init__(self, tree: Any) -> None:
        self._tree = tree
        self._places: dict[int, int] = {}

    def place(self, node: Any, column: int) -> Any:
        row = self._places.get(column, 0)
        self._places[column] = row + 1
        node.location = (column * _SPACING, -row * _SPACING)
        return node

    def math(self, operation: str, a: Any, b: Any, column: int, *, label: str = "", clamp: bool = False) -> Any:
        """A socket with the result; a and b are sockets or numbers."""
        node = self.place(compat.compositor_node(self._tree, "Math"), column)
        node.operation, node.label, node.use_clamp = operation, label, clamp
        for socket, value in zip(node.inputs, (a, b), strict=False):
            if isinstance(value, int | float):
                socket.default_value = value
            elif value is not None:
                self._tree.links.new(value, socket)
        return node.outputs[0]


def node_group() -> Any:
    """The group, made unless the file has it.

    In: A, B and Reference (V, one value a pixel), Position (0 .. 1 of the width), Softness (width of the edge, share of
    the picture's), Scale of the difference, and the error at the end of the false colours' scale.
    Out: the wipe, A to the left and B to the right; |A - B| x scale; and |wipe - reference| in the report's colours.
    """
    found = bpy.data.node_groups.get(GROUP)
    if found is not None and found.get(_MARK) == _VERSION:
        return found
    group = bpy.data.node_groups.new(GROUP, "CompositorNodeTree")
    group[_MARK] = _VERSION
    for name, default, low, high in (
        ("A", 1.0, None, None),
        ("B", 1.0, None, None),
        ("Reference", 1.0, None, None),
        ("Position", 0.5, 0.0, 1.0),
        ("Softness", 0.0, 0.0, 1.0),
        ("Difference Scale", 1.0 / images.ERROR_SCALE, 0.0, 1000.0),
        ("Error Scale", images.ERROR_SCALE, 1e-4, 1.0),
    ):
        socket = group.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketFloat")
        socket.default_value = default
        if low is not None:
            socket.min_value, socket.max_value, socket.subtype = low, high, "FACTOR" if high == 1.0 else "NONE"
    for name, kind in zip(OUTPUTS, ("Float", "Float", "Color"), strict=True):
        group.interface.new_socket(name, in_out="OUTPUT", socket_type=f"NodeSocket{kind}")

    build = _Builder(group)
    given = build.place(group.nodes.new("NodeGroupInput"), 0).outputs
    out = build.place(group.nodes.new("NodeGroupOutput"), 13).inputs
    across = compat.compositor_across(group, given["A"])
    for node in group.nodes:
        if node.bl_idname not in ("NodeGroupInput", "NodeGroupOutput"):
            build.place(node, 1)
    # The share of B: 0 left of the line, 1 right of it. The sum of both parts leaves A and B as they are, to the bit.
    distance = build.math("SUBTRACT", across, given["Position"], 2, label="right of the line")
    edge = build.math("MAXIMUM", given["Softness"], 1e-6, 2, label="edge")
    ramp = build.math("DIVIDE", distance, edge, 3)
    share_b = build.math("ADD", ramp, 0.5, 4, label="share of B", clamp=True)
    share_a = build.math("SUBTRACT", 1.0, share_b, 5, label="share of A")
    left = build.math("MULTIPLY", given["A"], share_a, 6)
    right = build.math("MULTIPLY", given["B"], share_b, 6)
    wipe = build.math("ADD", left, right, 7, label="wipe")
    group.links.new(wipe, out["Wipe"])
    apart = build.math("ABSOLUTE", build.math("SUBTRACT", given["A"], given["B"], 2), None, 3)
    group.links.new(build.math("MULTIPLY", apart, given["Difference Scale"], 4, label="difference"), out["Difference"])
    error = build.math("ABSOLUTE", build.math("SUBTRACT", wipe, given["Reference"], 8), None, 9)
    shown = build.math("DIVIDE", error, given["Error Scale"], 10, label="error", clamp=True)
    colour = build.place(compat.compositor_node(group, "ValToRGB"), 11)
    _fill(colour.color_ramp)
    group.links.new(shown, colour.inputs[0])
    group.links.new(colour.outputs[0], out["False Colour"])
    return group


def _fill(ramp: Any) -> None:
    """The colours of the report's error pictures, as scene-linear light."""
    stops = colours.stops("inferno")
    last = len(stops) - 1
    ramp.interpolation = "LINEAR"
    while len(ramp.elements) < len(stops):
        ramp.elements.new(0.5)
    for number, code in enumerate(stops):
        ramp.elements[number].position = number / last
        ramp.elements[number].color = (*(_linear(int(value)) for value in code), 1.0)


def add(scene: Any, view_layer: Any, technique_a: str, technique_b: str, light: str = "") -> Any:
    """Switches the passes on, adds or finds the group's node, and wires it. @returns the node

    light: whose passes are taken where the view layer has one for each light; "" for the first
    """
    chosen = view_layer.penumbra
    chosen.visibility = set(chosen.visibility) | {technique_a, technique_b}
    chosen.use_reference = True
    scene.render.use_compositing = True
    tree = compat.compositor_tree(scene, make=True)
    assert tree is not None
    view_layer.update_render_passes()
    source = _render_layers(tree, scene, view_layer)
    node = next((node for node in tree.nodes if node.get(_MARK)), None)
    if node is None:
        node = tree.nodes.new("CompositorNodeGroup")
        node[_MARK] = _VERSION
        node.location = (source.location[0] + 320.0, source.location[1])
        node.width = 220.0
    node.node_tree = node_group()
    names = _pass_names(scene, view_layer, light)
    for socket, technique in (("A", technique_a), ("B", technique_b), ("Reference", "")):
        tree.links.new(source.outputs[names[technique]], node.inputs[socket])
    node.label = f"{_title(technique_a)} | {_title(technique_b)}"
    return node


def _title(technique: str) -> str:
    return str(catalogue.technique(technique)["title"])


def _render_layers(tree: Any, scene: Any, view_layer: Any) -> Any:
    """The node with this view layer's passes."""
    for node in tree.nodes:
        if node.bl_idname == "CompositorNodeRLayers" and node.scene == scene and node.layer == view_layer.name:
            return node
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene, node.layer = scene, view_layer.name
    return node


def _pass_names(scene: Any, view_layer: Any, light: str) -> dict[str, str]:
    """By technique the name of its visibility pass; "" for the reference."""
    names: dict[str, str] = {}
    for entry in passes.pass_list(view_layer, passes.light_names(scene)):
        if entry.what != "error" and (not light or not entry.light or entry.light == light):
            names.setdefault(entry.technique, entry.name)
    return names


def send(node: Any, output: str) -> bool:
    """Makes an output of the group the render's picture. False if something else of the artist's is there already."""
    tree = node.id_data
    target = compat.compositor_output(tree)
    maker = _maker(target)
    if maker is not None and maker != node and maker.bl_idname != "CompositorNodeRLayers":
        return False
    tree.links.new(node.outputs[output], target)
    if target.node.location[0] <= node.location[0] + node.width:
        target.node.location = (node.location[0] + node.width + 80.0, node.location[1])
    return True


def _maker(socket: Any) -> Any | None:
    """The node whose picture arrives here, past what only carries it on; a new file's tree has such."""
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.bl_idname != "NodeReroute":
            return node
        socket = node.inputs[0]
    return None


@with_properties(
    technique_a=bpy.props.EnumProperty(
        name="A", description="The technique on the left", items=technique_items(), default="shadow_map"
    ),
    technique_b=bpy.props.EnumProperty(
        name="B", description="The technique on the right", items=technique_items(), default="ray_traced"
    ),
    show=bpy.props.EnumProperty(
        name="Show",
        description="What becomes the render's picture",
        items=[
            ("Wipe", "Wipe", "A on the left of a line, B on its right"),
            ("Difference", "Difference", "How far A and B are apart"),
            ("False Colour", "False Colour", "How far each side is from the reference, in the report's colours"),
            ("NONE", "Nothing", "Leave the render's picture as it is"),
        ],
        default="Wipe",
    ),
    light=bpy.props.StringProperty(
        name="Light", description="Whose passes are taken where there is one for each light; empty for the first"
    ),
)
class PENUMBRA_OT_compositor_compare(bpy.types.Operator):  # noqa: N801
    """Add a node group that wipes between two techniques, shows their difference, and their errors in false colours"""

    bl_idname = "penumbra.compositor_compare"
    bl_label = "Compare in the Compositor"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Any) -> bool:
        if context.scene is None or context.scene.render.engine != ENGINE:
            cls.poll_message_set("The passes come from the render engine Penumbra; choose it first")
            return False
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        chosen = context.scene.penumbra.technique
        self.technique_a, self.technique_b = chosen, "shadow_map" if chosen == "ray_traced" else "ray_traced"
        return self.execute(context)

    def execute(self, context: Any) -> set[str]:
        lights = passes.light_names(context.scene)
        if self.light and self.light not in lights:
            self.report({"WARNING"}, f'There is no light "{self.light}"; the passes of the first are taken')
        light = self.light if self.light in lights else ""
        node = add(context.scene, context.view_layer, self.technique_a, self.technique_b, light)
        if self.show != "NONE" and not send(node, self.show):
            self.report({"INFO"}, f'The output has a picture already; connect "{self.show}" where you want it')
        return {"FINISHED"}


class PENUMBRA_PT_compositor(bpy.types.Panel):  # noqa: N801
    bl_label = "Compare Passes"
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Penumbra"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.space_data is not None and context.space_data.tree_type == "CompositorNodeTree")

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.operator(PENUMBRA_OT_compositor_compare.bl_idname, icon="NODE_COMPOSITING")
        tree = compat.compositor_tree(context.scene, make=False)
        node = next((node for node in tree.nodes if node.get(_MARK)), None) if tree is not None else None
        if node is None:
            return
        for socket in node.inputs:
            if not socket.is_linked:
                layout.prop(socket, "default_value", text=socket.name)


class PENUMBRA_PT_compositor_passes(bpy.types.Panel):  # noqa: N801
    bl_label = "Compositor"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "view_layer"
    bl_parent_id = "PENUMBRA_PT_passes"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012

    def draw(self, context: Any) -> None:
        self.layout.operator(PENUMBRA_OT_compositor_compare.bl_idname, icon="NODE_COMPOSITING")


_CLASSES = (PENUMBRA_OT_compositor_compare, PENUMBRA_PT_compositor, PENUMBRA_PT_compositor_passes)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
