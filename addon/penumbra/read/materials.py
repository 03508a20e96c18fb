"""What the bridge takes from Blender's materials: one colour, and whether the surface glows.

Shader nodes are not evaluated. We follow the surface from the active output to the closures, through reroutes, groups,
mixes and sums, and take the values set on their sockets. A colour that comes from a texture or other nodes is replaced
by the material's viewport colour, and that is noted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .. import compat
from .notes import Notes

Colour = tuple[float, float, float]
BLACK: Colour = (0.0, 0.0, 0.0)
GREY: Colour = (0.8, 0.8, 0.8)
_MAX_DEPTH = 32


@dataclass(frozen=True)
class Surface:
    """Linear diffuse colour; radiance where it glows (None: it glows, but how is not known)."""

    albedo: Colour
    emission: Colour | None = BLACK

    @property
    def emits(self) -> bool:
        return self.emission is None or max(self.emission) > 0.0


def _clamped(colour: Colour) -> Colour:
    r, g, b = (min(max(float(c), 0.0), 1.0) if math.isfinite(c) else 0.0 for c in colour)
    return r, g, b


def _mixed(a: Colour, b: Colour, t: float) -> Colour:
    return a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t


def _sum(a: Colour, b: Colour) -> Colour:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _source(socket: Any) -> Any | None:
    """The node that feeds a socket, behind reroutes and into groups; None if nothing does."""
    for _ in range(_MAX_DEPTH):
        if not socket.is_linked or not socket.links:
            return None
        link = socket.links[0]
        if getattr(link, "is_muted", False):
            return None
        node = link.from_node
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.type == "GROUP" and node.node_tree is not None:
            outputs = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            inner = outputs[0].inputs.get(link.from_socket.name) if outputs else None
            if inner is None:
                return None
            socket = inner
        else:
            return node
    return None


def _input(node: Any, *names: str) -> Any | None:
    for name in names:
        socket = node.inputs.get(name)
        if socket is not None:
            return socket
    return None


class Reader:
    """Reads each material once."""

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._known: dict[int, Surface] = {}

    def surface(self, material: Any | None) -> Surface:
        if material is None:
            return Surface(GREY)
        key = int(material.as_pointer())
        known = self._known.get(key)
        if known is None:
            known = self._read(material)
            self._known[key] = known
        return known

    def light_factor(self, light: Any, name: str) -> Colour:
        """What a light's own nodes multiply its colour by: strength times colour of a plain Emission node."""
        tree = compat.node_tree(light)
        if tree is None:
            return 1.0, 1.0, 1.0
        output = tree.get_output_node("CYCLES")
        node = _source(output.inputs["Surface"]) if output is not None else None
        if node is None or node.type != "EMISSION":
            self._notes.add("the light's nodes are not read; its plain colour and energy are used", name)
            return 1.0, 1.0, 1.0
        emission = self._emission(node, "Color", "Strength")
        if emission is None:
            self._notes.add("the light's nodes are not read; its plain colour and energy are used", name)
            return 1.0, 1.0, 1.0
        return emission

    def world_radiance(self, world: Any) -> Colour | None:
        """Of an even sky; None where nodes make it that are not read."""
        tree = compat.node_tree(world)
        if tree is None:
            r, g, b = world.color
            return float(r), float(g), float(b)
        output = tree.get_output_node("CYCLES")
        node = _source(output.inputs["Surface"]) if output is not None else None
        if node is None:
            return BLACK
        return self._emission(node, "Color", "Strength") if node.type == "BACKGROUND" else None

    def _read(self, material: Any) -> Surface:
        viewport: Colour = tuple(material.diffuse_color)[:3]
        tree = compat.node_tree(material)
        if tree is None:
            return Surface(_clamped(viewport))
        output = tree.get_output_node("CYCLES")
        node = _source(output.inputs["Surface"]) if output is not None else None
        if node is None:
            self._notes.add("the material has no surface; its viewport colour is used", material.name)
            return Surface(_clamped(viewport))
        walk = _Walk(self, material.name, viewport)
        albedo, emission = walk.shader(node, 0)
        if walk.textured:
            self._notes.add("its colour comes from a texture or nodes; its viewport colour is used", material.name)
        if walk.see_through:
            self._notes.add("the material lets light through in Blender; it is taken as opaque", material.name)
        return Surface(_clamped(albedo), emission)

    @staticmethod
    def _emission(node: Any, colour_name: str, strength_name: str) -> Colour | None:
        """Strength times colour, or None where nodes feed either of them."""
        colour, strength = node.inputs.get(colour_name), node.inputs.get(strength_name)
        if colour is None or strength is None:
            return BLACK
        if strength.is_linked or colour.is_linked:
            if not strength.is_linked and strength.default_value == 0.0:
                return BLACK
            source = _source(colour)
            if strength.is_linked or source is None or source.type != "RGB":
                return None
            rgb = source.outputs[0].default_value
        else:
            rgb = colour.default_value
        s = max(float(strength.default_value), 0.0)
        return max(float(rgb[0]), 0.0) * s, max(float(rgb[1]), 0.0) * s, max(float(rgb[2]), 0.0) * s


class _Walk:
    """One walk over one material's closures."""

    def __init__(self, reader: Reader, name: str, viewport: Colour) -> None:
        self.reader = reader
        self.name = name
        self.viewport = viewport
        self.textured = False
        self.see_through = False

    def shader(self, node: Any | None, depth: int) -> tuple[Colour, Colour | None]:
        """Diffuse colour and radiance of a closure."""
        if node is None or depth > _MAX_DEPTH:
            return BLACK, BLACK
        kind = node.type
        if kind in {"MIX_SHADER", "ADD_SHADER"}:
            return self._pair(node, kind == "MIX_SHADER", depth)
        if kind == "EMISSION":
            emission = self.reader._emission(node, "Color", "Strength")
            # Such a surface reflects nothing, yet a lamp drawn black would look wrong: it shows its own colour.
            return self._colour(node.inputs["Color"]), emission
        if kind == "BSDF_PRINCIPLED":
            return self._principled(node)
        if kind in {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION", "HOLDOUT"}:
            self.see_through = True
        colour = _input(node, "Color", "Base Color")
        return (self._colour(colour) if colour is not None else self.viewport), BLACK

    def _principled(self, node: Any) -> tuple[Colour, Colour | None]:
        for name in ("Transmission Weight", "Transmission"):
            socket = node.inputs.get(name)
            if socket is not None and (socket.is_linked or socket.default_value > 0.0):
                self.see_through = True
        alpha = node.inputs.get("Alpha")
        if alpha is not None and (alpha.is_linked or alpha.default_value < 1.0):
            self.see_through = True
        emission = self.reader._emission(node, "Emission Color", "Emission Strength")
        return self._colour(node.inputs["Base Color"]), emission

    def _pair(self, node: Any, mix: bool, depth: int) -> tuple[Colour, Colour | None]:
        shaders = [socket for socket in node.inputs if socket.type == "SHADER"]
        (a, glow_a), (b, glow_b) = (self.shader(_source(socket), depth + 1) for socket in shaders[:2])
        if not mix:
            glow = None if glow_a is None or glow_b is None else _sum(glow_a, glow_b)
            return _sum(a, b), glow
        factor = node.inputs[0]
        t = 0.5 if factor.is_linked else float(factor.default_value)
        if glow_a is None or glow_b is None or (factor.is_linked and glow_a != glow_b):
            return _mixed(a, b, t), None
        return _mixed(a, b, t), _mixed(glow_a, glow_b, t)

    def _colour(self, socket: Any) -> Colour:
        source = _source(socket)
        if source is None and not socket.is_linked:
            r, g, b = tuple(socket.default_value)[:3]
            return float(r), float(g), float(b)
        if source is not None and source.type == "RGB":
            r, g, b = tuple(source.outputs[0].default_value)[:3]
            return float(r), float(g), float(b)
        self.textured = True
        return self.viewport
