"""Makes the three example scenes beside this file, always the same.

    python examples/make_examples.py [--only NAME] [--out DIR]

Needs Blender as a Python module (pip install 'penumbra[bpy]'). Lengths are metres.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import bpy  # first: the two below come into being with it

# isort: split
import bmesh
from mathutils import Matrix, Vector

Triple = tuple[float, float, float]
SIZE = (640, 360)


# ------------------------------------------------------------------------------------------------------------- the kit


def begin() -> Any:
    """An empty scene at 640 x 360."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    scene.world = world
    return scene


def paint(name: str, colour: Triple) -> Any:
    """A matt material."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = 0.9
    shader.inputs["Specular IOR Level"].default_value = 0.1
    material.diffuse_color = (*colour, 1.0)
    return material


def place(
    name: str,
    data: Any,
    at: Triple = (0, 0, 0),
    turn: Triple = (0, 0, 0),
    scale: float | Triple = 1.0,
    into: Any = None,
) -> Any:
    """An object; `turn` in degrees."""
    obj = bpy.data.objects.new(name, data)
    obj.location = at
    obj.rotation_euler = tuple(math.radians(a) for a in turn)
    obj.scale = (scale,) * 3 if isinstance(scale, float | int) else scale
    (into or bpy.context.scene.collection).objects.link(obj)
    return obj


def mesh_of(name: str, make: Callable[[Any], object], material: Any, smooth: bool = False) -> Any:
    """A mesh from what `make` does to an empty bmesh."""
    shape = bmesh.new()
    make(shape)
    bmesh.ops.recalc_face_normals(shape, faces=shape.faces)
    for face in shape.faces:
        face.smooth = smooth
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    mesh.materials.append(material)
    return mesh


def box(size: Triple, at: Triple = (0, 0, 0)) -> Callable[[Any], object]:
    """A box that stands on `at`."""
    middle = Matrix.Translation((at[0], at[1], at[2] + size[2] / 2))
    return lambda shape: bmesh.ops.create_cube(shape, size=1.0, matrix=middle @ Matrix.Diagonal((*size, 1.0)))


def tube(radius: float, height: float, at: Triple = (0, 0, 0), segments: int = 24, top: float | None = None) -> Any:
    """A cylinder or cone that stands on `at`."""
    return lambda shape: bmesh.ops.create_cone(
        shape,
        cap_ends=True,
        segments=segments,
        radius1=radius,
        radius2=radius if top is None else top,
        depth=height,
        matrix=Matrix.Translation((at[0], at[1], at[2] + height / 2)),
    )


def turned(profile: Iterable[tuple[float, float]], segments: int = 32) -> Callable[[Any], object]:
    """A body turned on a lathe from (radius, height) pairs, from the bottom up."""

    def make(shape: Any) -> None:
        rings = []
        for radius, height in profile:
            angles = [2 * math.pi * k / segments for k in range(segments)]
            rings.append([shape.verts.new((radius * math.cos(a), radius * math.sin(a), height)) for a in angles])
        for low, high in itertools.pairwise(rings):
            for k in range(segments):
                shape.faces.new((low[k], low[(k + 1) % segments], high[(k + 1) % segments], high[k]))
        shape.faces.new(reversed(rings[0]))
        shape.faces.new(rings[-1])

    return make


def several(*parts: Callable[[Any], object]) -> Callable[[Any], object]:
    def make(shape: Any) -> None:
        for part in parts:
            part(shape)

    return make


def sphere(radius: float, at: Triple = (0, 0, 0), detail: int = 2) -> Callable[[Any], object]:
    where = Matrix.Translation(at)
    return lambda shape: bmesh.ops.create_icosphere(shape, subdivisions=detail, radius=radius, matrix=where)


def wire(
    name: str, points: Iterable[Triple], radius: float, material: Any, cyclic: bool = False, smooth: int = 0
) -> Any:
    """A thin round wire through points; smooth > 0 rounds its corners."""
    points = list(points)
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = radius
    curve.bevel_resolution = 2
    curve.use_fill_caps = True
    curve.resolution_u = max(smooth, 1)
    spline = curve.splines.new("NURBS" if smooth else "POLY")
    spline.points.add(len(points) - 1)
    for point, where in zip(spline.points, points, strict=True):
        point.co = (*where, 1.0)
    spline.use_cyclic_u = cyclic
    if smooth:
        spline.order_u = 3
        spline.use_endpoint_u = True
    curve.materials.append(material)
    return curve


def look(obj: Any, target: Triple) -> Any:
    """Turn an object so that its -z axis points to the target."""
    obj.rotation_euler = (Vector(target) - obj.location).to_track_quat("-Z", "Y").to_euler()
    return obj


def camera(at: Triple, target: Triple, lens: float, clip: tuple[float, float] = (0.1, 200.0)) -> Any:
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    data.clip_start, data.clip_end = clip
    obj = look(place("Camera", data, at), target)
    bpy.context.scene.camera = obj
    return obj


def light(name: str, kind: str, at: Triple, target: Triple, watts: float, **settings: Any) -> Any:
    data = bpy.data.lights.new(name, kind)
    data.energy = watts
    if hasattr(data, "use_soft_falloff"):
        data.use_soft_falloff = False  # a true sphere, which Penumbra computes too
    for key, value in settings.items():
        setattr(data, key, value)
    return look(place(name, data, at), target)


# ----------------------------------------------------------------------------------------------------------- courtyard


def courtyard() -> None:
    """Suzanne among pillars and behind a fence, under one large area light."""
    begin()
    stone = paint("Stone", (0.72, 0.68, 0.60))
    paving = paint("Paving", (0.62, 0.60, 0.57))
    wood = paint("Wood", (0.45, 0.29, 0.16))
    bronze = paint("Bronze", (0.80, 0.52, 0.27))
    leaf = paint("Leaf", (0.23, 0.42, 0.17))
    clay = paint("Clay", (0.68, 0.34, 0.22))

    place("Ground", mesh_of("Ground", box((26, 26, 0.5), (0, 0, -0.5)), paving))
    # The walls stand a little apart from the ground's edge; the one to the camera is left out.
    place("Back wall", mesh_of("Back wall", box((17, 0.5, 4.2), (0, 7.2, 0)), stone))
    place("Left wall", mesh_of("Left wall", box((0.5, 14, 4.2), (-8.3, 0, 0)), stone))

    base = [(0.52, 0.0), (0.52, 0.16), (0.44, 0.22), (0.40, 0.34), (0.34, 0.40)]
    shaft = [(0.34, 0.42), (0.345, 1.2), (0.32, 2.2), (0.28, 3.05)]
    head = [(0.33, 3.12), (0.33, 3.2), (0.40, 3.3), (0.48, 3.42), (0.48, 3.6)]
    pillar = mesh_of("Pillar", turned(base + shaft + head, 48), stone, smooth=True)
    for x in (-5.4, -1.8, 1.8, 5.4):
        place(f"Pillar back {x:+.1f}", pillar, (x, 4.6, 0))
    for y in (1.0, -2.6):
        place(f"Pillar left {y:+.1f}", pillar, (-5.4, y, 0))
    place("Beam back", mesh_of("Beam back", box((11.9, 0.8, 0.55), (0, 4.6, 3.6)), stone))
    place("Beam left", mesh_of("Beam left", box((0.8, 7.6, 0.55), (-5.4, 0.8, 3.6)), stone))

    steps = several(box((2.6, 2.6, 0.22)), box((1.9, 1.9, 0.22), (0, 0, 0.22)), box((1.2, 1.2, 0.75), (0, 0, 0.44)))
    place("Plinth", mesh_of("Plinth", steps, stone), (0, 0.2, 0), (0, 0, 12))

    def monkey(shape: Any) -> None:
        bmesh.ops.create_monkey(shape)

    suzanne = place("Suzanne", mesh_of("Suzanne", monkey, bronze, smooth=True), (0, 0.2, 2.02), (-12, 0, 24), 0.92)
    suzanne.modifiers.new("Subdivision", "SUBSURF").levels = 1
    suzanne.modifiers["Subdivision"].render_levels = 1

    # A picket fence: one picket, repeated by an array modifier, and two rails.
    picket = mesh_of("Picket", several(box((0.09, 0.035, 1.0)), tube(0.064, 0.16, (0, 0, 1.0), 4, 0.0)), wood)
    rails = mesh_of(
        "Rails", several(box((6.2, 0.04, 0.08), (0, 0.04, 0.25)), box((6.2, 0.04, 0.08), (0, 0.04, 0.75))), wood
    )
    post = mesh_of("Post", several(box((0.14, 0.14, 1.3)), sphere(0.09, (0, 0, 1.36), 3)), wood)
    for name, at, turn in (("front", (1.6, -3.6, 0), 0.0), ("side", (5.2, -0.2, 0), 90.0)):
        row = place(f"Fence {name}", picket, at, (0, 0, turn))
        across = Vector((math.cos(math.radians(turn)), math.sin(math.radians(turn)), 0))
        row.location = Vector(at) - across * 2.99
        repeat = row.modifiers.new("Array", "ARRAY")
        repeat.count = 27
        repeat.use_relative_offset = False
        repeat.use_constant_offset = True
        repeat.constant_offset_displace = (0.23, 0, 0)
        place(f"Rails {name}", rails, at, (0, 0, turn))
        for end in (-1, 1):
            place(f"Post {name} {end:+d}", post, tuple(Vector(at) + across * (3.17 * end)))

    pot = mesh_of(
        "Pot", turned([(0.22, 0), (0.34, 0.42), (0.37, 0.42), (0.37, 0.52), (0.31, 0.52), (0.30, 0.46)], 24), clay, True
    )
    crown = mesh_of("Crown", sphere(0.46, detail=4), leaf, smooth=True)
    trunk = mesh_of("Trunk", tube(0.045, 0.6, segments=10), wood, smooth=True)
    for k, (x, y) in enumerate(((-3.2, -2.6), (3.6, 2.4))):
        place(f"Pot {k + 1}", pot, (x, y, 0))
        place(f"Trunk {k + 1}", trunk, (x, y, 0.46))
        place(f"Crown {k + 1}", crown, (x, y, 1.42))

    light("Key", "AREA", (6.4, 2.4, 6.6), (-0.8, -0.6, 0.4), 850, shape="RECTANGLE", size=1.4, size_y=0.9)
    camera((4.6, -11.8, 5.9), (-0.9, -0.2, 1.0), 34)


# ---------------------------------------------------------------------------------------------------------------- desk


def desk() -> None:
    """Thin things that touch the table: pens, paper clips, a lamp's arm; a window and a lamp light them."""
    begin()
    top = paint("Table", (0.55, 0.42, 0.30))
    paper = paint("Paper", (0.82, 0.82, 0.80))
    steel = paint("Steel", (0.45, 0.46, 0.48))
    lacquer = paint("Lacquer", (0.10, 0.30, 0.42))
    red = paint("Red", (0.65, 0.10, 0.08))
    yellow = paint("Yellow", (0.80, 0.58, 0.10))
    green = paint("Green", (0.14, 0.40, 0.20))
    china = paint("China", (0.80, 0.78, 0.74))

    place("Table", mesh_of("Table", box((1.6, 0.9, 0.03), (0, 0, -0.03)), top))
    place("Wall", mesh_of("Wall", box((3.0, 0.04, 1.6), (0, 0.62, -0.2)), china))
    place("Sheet", mesh_of("Sheet", box((0.21, 0.297, 0.0004)), paper), (-0.02, -0.16, 0), (0, 0, 14))

    cup = mesh_of("Cup", turned([(0.034, 0), (0.038, 0.1), (0.034, 0.1), (0.031, 0.006)], 40), lacquer, True)
    place("Pen cup", cup, (0.03, 0.13, 0))
    pens = ((red, 9, 40), (yellow, 14, 160), (green, 12, 260), (steel, 7, 310))
    for k, (ink, lean, way) in enumerate(pens):
        pen = mesh_of(
            f"Pencil {k + 1}",
            several(tube(0.0035, 0.16, segments=8), tube(0.0035, 0.014, (0, 0, 0.16), 8, 0.0003)),
            ink,
        )
        place(f"Pencil {k + 1}", pen, (0.03, 0.13, 0.008), (0, lean, way))
    for k, (ink, x, y, turn) in enumerate(((red, 0.02, -0.17, 62), (lacquer, 0.16, -0.27, -24))):
        pen = mesh_of(
            f"Pen {k + 1}",
            several(tube(0.0042, 0.13, segments=12), tube(0.0042, 0.012, (0, 0, 0.13), 12, 0.0005)),
            ink,
            True,
        )
        place(f"Pen {k + 1}", pen, (x, y, 0.0046), (0, 90, turn))

    # A paper clip: one bent wire, 1 mm thick.
    bends = [(0, 0), (0.026, 0), (0.032, 0.003), (0.026, 0.0065), (0.004, 0.0065), (-0.001, 0.0035), (0.004, 0.001)]
    bends += [(0.021, 0.001), (0.0245, 0.003), (0.021, 0.0052), (0.008, 0.0052)]
    clip = wire("Paper clip", ((x, y, 0) for x, y in bends), 0.0005, steel, smooth=4)
    for k, (x, y, turn) in enumerate(((0.11, -0.10, 10), (0.135, -0.075, 75), (0.165, -0.12, 140), (-0.13, -0.3, 33))):
        place(f"Paper clip {k + 1}", clip, (x, y, 0.0006), (0, 0, turn))
    place("Paper clip upright", clip, (0.09, -0.15, 0.004), (90, 0, 40))

    for k, (colour, size, lift, turn) in enumerate(
        (
            (green, (0.17, 0.24, 0.022), 0.0, 8),
            (red, (0.15, 0.22, 0.03), 0.022, -6),
            (lacquer, (0.13, 0.19, 0.016), 0.052, 17),
        )
    ):
        place(f"Book {k + 1}", mesh_of(f"Book {k + 1}", box(size), colour), (0.3, 0.13, lift), (0, 0, turn))

    mug = mesh_of(
        "Mug", turned([(0.036, 0), (0.041, 0.01), (0.041, 0.092), (0.038, 0.092), (0.037, 0.008)], 48), china, True
    )
    place("Mug", mug, (0.3, -0.12, 0))
    handle = wire(
        "Mug handle", ((0.04, 0, 0.075), (0.075, 0, 0.078), (0.078, 0, 0.025), (0.04, 0, 0.02)), 0.0042, china, smooth=8
    )
    place("Mug handle", handle, (0.3, -0.12, 0), (0, 0, -35))

    # The lamp: foot, two thin arms, and a shade that hides the bulb from the camera.
    place(
        "Lamp foot",
        mesh_of("Lamp foot", turned([(0.08, 0), (0.08, 0.012), (0.02, 0.022)], 48), steel, True),
        (-0.40, 0.24, 0),
    )
    elbow, tip = (-0.50, 0.26, 0.27), (-0.27, 0.12, 0.36)
    for k, shift in enumerate((-0.011, 0.011)):
        arm = [(-0.40 + shift, 0.24, 0.02), (elbow[0] + shift, elbow[1], elbow[2]), (tip[0] + shift, tip[1], tip[2])]
        place(f"Lamp arm {k + 1}", wire(f"Lamp arm {k + 1}", arm, 0.004, steel))
    shade = mesh_of(
        "Lamp shade",
        turned([(0.075, -0.08), (0.03, 0.02), (0.012, 0.035), (0.010, 0.033), (0.028, 0.018), (0.073, -0.08)], 48),
        lacquer,
        True,
    )
    # The lathe closes both ends: the lowest ring must stay open, or no light leaves the shade.
    open_ends(shade)
    place("Lamp shade", shade, tip, (-12, -32, 0))

    light("Window", "AREA", (1.05, 0.12, 0.72), (0.0, 0.0, 0.0), 13, shape="RECTANGLE", size=0.26, size_y=0.2)
    lamp = light("Lamp", "SPOT", (tip[0] + 0.02, tip[1] - 0.008, tip[2] - 0.04), (0.02, -0.02, 0), 5.0)
    lamp.data.shadow_soft_size = 0.015
    lamp.data.spot_size = math.radians(110)
    lamp.data.spot_blend = 0.4
    lamp.data.color = (1.0, 0.83, 0.62)
    camera((0.16, -0.98, 0.62), (-0.03, 0.02, 0.07), 38, (0.02, 20.0))


def open_ends(mesh: Any) -> None:
    """Remove the two end caps of a turned body."""
    shape = bmesh.new()
    shape.from_mesh(mesh)
    bmesh.ops.delete(shape, geom=[face for face in shape.faces if len(face.verts) > 4], context="FACES_ONLY")
    shape.to_mesh(mesh)
    shape.free()


# --------------------------------------------------------------------------------------------------------------- plaza


def plaza() -> None:
    """A square a kilometre wide: towers, a colonnade, trees, a monument in the sun and in a spot light."""
    begin()
    ground = paint("Ground", (0.55, 0.53, 0.50))
    concrete = paint("Concrete", (0.62, 0.60, 0.58))
    brick = paint("Brick", (0.52, 0.30, 0.22))
    glass = paint("Facade", (0.34, 0.42, 0.50))
    marble = paint("Marble", (0.78, 0.76, 0.72))
    leaf = paint("Leaf", (0.20, 0.36, 0.14))
    bark = paint("Bark", (0.28, 0.20, 0.14))

    place("Ground", mesh_of("Ground", box((1200, 1200, 1), (0, 0, -1)), ground))

    house = {
        name: mesh_of(name, box((1, 1, 1)), colour)
        for name, colour in (("Block", concrete), ("Brick", brick), ("Tower", glass))
    }
    # A ring of buildings; the side of the camera stays open. Sizes follow a fixed pattern, not a random generator.
    for k in range(22):
        angle = math.radians(-58 + k * (296 / 21))
        away = 260 + 46 * ((k * 7) % 5)
        height = 26 + 17 * ((k * 5) % 7) + (90 if k % 6 == 2 else 0)
        name = ("Tower", "Block", "Brick")[k % 3]
        scale = (34 + 9 * (k % 4), 30 + 8 * ((k * 3) % 5), height)
        at = (away * math.cos(angle), away * math.sin(angle), 0)
        place(f"{name} {k + 1}", house[name], at, (0, 0, math.degrees(angle) + 8 * (k % 3)), scale)

    # A colonnade on a half circle round the monument.
    profile = [(1.1, 0), (1.1, 0.5), (0.85, 0.8), (0.8, 8.6), (1.15, 9.2), (1.15, 9.8)]
    column = mesh_of("Column", turned(profile, 28), marble, smooth=True)
    for k in range(19):
        angle = math.radians(20 + k * 140 / 18)
        place(f"Column {k + 1}", column, (44 * math.cos(angle), 44 * math.sin(angle), 0))
    place("Architrave", mesh_of("Architrave", arc(44, 2.4, 9.8, 11.6, 20, 160, 72), marble))

    # Trees are instances of one collection.
    tree = bpy.data.collections.new("Tree")
    place("Trunk", mesh_of("Trunk", tube(0.35, 4.2, segments=10, top=0.22), bark, True), into=tree)
    for k, (x, y, z, r) in enumerate(
        ((0, 0, 6.4, 2.6), (1.5, 0.6, 5.3, 1.7), (-1.3, 0.9, 5.6, 1.6), (0.2, -1.5, 5.2, 1.7))
    ):
        place(f"Foliage {k + 1}", mesh_of(f"Foliage {k + 1}", sphere(r, (x, y, z), 3), leaf, True), into=tree)
    for k in range(26):
        side = -1 if k % 2 else 1
        spot = place(
            f"Tree {k + 1}",
            None,
            (side * (17 + (k % 3)), -66 + 6.5 * (k // 2), 0),
            (0, 0, 47 * k),
            0.8 + 0.09 * (k % 5),
        )
        spot.instance_type = "COLLECTION"
        spot.instance_collection = tree

    steps = several(*(tube(9 - 1.6 * k, 0.5, (0, 0, 0.5 * k), 48) for k in range(4)))
    place("Steps", mesh_of("Steps", steps, marble), (0, 14, 0))
    obelisk = several(
        box((4.2, 4.2, 3.0), (0, 0, 2)), tube(1.9, 21, (0, 0, 5), 4, 1.15), tube(1.15, 2.2, (0, 0, 26), 4, 0.0)
    )
    place("Obelisk", mesh_of("Obelisk", obelisk, marble), (0, 14, 0), (0, 0, 45))

    lamp_post = several(tube(0.12, 7.0, segments=10, top=0.07), sphere(0.3, (0, 0, 7.1), 2))
    post = mesh_of("Lamp post", lamp_post, concrete, True)
    for k in range(8):
        place(f"Lamp post {k + 1}", post, ((-1) ** k * 9.5, -60 + 17 * (k // 2), 0))

    sun = light("Sun", "SUN", (0, 0, 200), (0, 0, 0), 3.2)
    sun.rotation_euler = (math.radians(42), 0, math.radians(-72))
    sun.data.angle = math.radians(1.6)
    flood = light("Flood", "SPOT", (-27, -15, 12), (0, 14, 10), 60000)
    flood.data.shadow_soft_size = 0.5
    flood.data.spot_size = math.radians(48)
    flood.data.spot_blend = 0.2
    flood.data.color = (1.0, 0.8, 0.55)
    camera((34, -88, 27), (-4, 10, 9), 30, (0.5, 2500.0))


def arc(
    radius: float, width: float, low: float, high: float, start: float, end: float, parts: int
) -> Callable[[Any], object]:
    """A curved beam round the z axis, angles in degrees."""

    def make(shape: Any) -> None:
        rings = []
        for k in range(parts + 1):
            angle = math.radians(start + (end - start) * k / parts)
            corners = [
                (radius - width / 2, low),
                (radius + width / 2, low),
                (radius + width / 2, high),
                (radius - width / 2, high),
            ]
            rings.append([shape.verts.new((r * math.cos(angle), r * math.sin(angle), z)) for r, z in corners])
        for here, there in itertools.pairwise(rings):
            for k in range(4):
                shape.faces.new((here[k], here[(k + 1) % 4], there[(k + 1) % 4], there[k]))
        shape.faces.new(rings[0])
        shape.faces.new(reversed(rings[-1]))

    return make


# ---------------------------------------------------------------------------------------------------------------- main

EXAMPLES: dict[str, Callable[[], None]] = {"courtyard": courtyard, "desk": desk, "plaza": plaza}


def save(path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True, relative_remap=False)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--only", choices=sorted(EXAMPLES), help="make this one alone")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder to write to")
    options = parser.parse_args(arguments)
    bpy.context.preferences.filepaths.save_version = 0
    for name, make in EXAMPLES.items():
        if options.only in (None, name):
            make()
            bpy.context.preferences.filepaths.save_version = 0
            save(options.out / f"{name}.blend")
            print(f"{options.out / name}.blend")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
