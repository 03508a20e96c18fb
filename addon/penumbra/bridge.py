"""From Blender to the core: an evaluated depsgraph in, a `penumbra_core.Scene` out.

This is the one file that turns Blender's data into the core's. It reads in bulk (no Python loop over vertices), sends
a mesh once however many instances show it, and writes down by name whatever it leaves out, places or approximates.

Conventions: world space is Blender's, metres, z up. A light's watts are Blender's own; the core turns them into
radiance. Matrices are float64 and map from local to world.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import compat
from .read import lights, materials, placing
from .read.cameras import Frame, read_frame, read_lens
from .read.errors import BridgeError
from .read.meshes import MeshArrays, read_mesh
from .read.notes import Notes, kept
from .read.transforms import DoubleArray, is_singular, matrix_of, unit

__all__ = ["NOTES_KEY", "BridgeError", "SceneExport", "read_scene"]

NOTES_KEY = "penumbra_notes"  # custom property of a scene: what `scenes.open_scene` put there

# Objects whose absence is no loss. Curves, surfaces, texts and metaballs are in the list twice: as themselves, and as
# an instance of the mesh that Blender made of them, which is what we take.
_SILENT_TYPES = frozenset(
    {
        "EMPTY",
        "CAMERA",
        "ARMATURE",
        "LATTICE",
        "SPEAKER",
        "LIGHT_PROBE",
        "LIGHTPROBE",
        "CURVE",
        "SURFACE",
        "FONT",
        "META",
    }
)


@dataclass(frozen=True)
class SceneExport:
    """A scene as the core takes it, and what had to be decided on the way."""

    scene: Any  # penumbra_core.Scene
    notes: list[str]  # one sentence each; names in quotes, counted, nothing twice
    lights: list[str]  # unique names, in the order of scene.lights
    camera: str
    size: tuple[int, int]  # width and height in pixels
    triangles: int  # of all instances
    frame: int
    objects: int = 0  # instances sent
    meshes: int = 0  # different meshes sent
    instance_names: list[str] = field(default_factory=list)  # unique, by the core's instance index
    world: tuple[float, float, float] = (0.0, 0.0, 0.0)  # radiance of an even sky; it casts no shadow


def read_scene(
    depsgraph: Any,
    *,
    scene: Any | None = None,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
) -> SceneExport:
    """Read what the depsgraph would render.

    depsgraph: evaluated; one of mode RENDER honours the render switches (see `scenes.render_depsgraph`), one of mode
        VIEWPORT honours those of the viewport.
    scene: the scene whose camera and render settings count; the depsgraph's by default.
    camera: name of a camera object; the scene's active camera by default; one is placed where there is none.
    size: width and height in pixels instead of the scene's resolution; the render border still cuts out its part.

    Raises BridgeError where nothing can be exported, and penumbra_core.InvalidScene where the core refuses.
    """
    return Reader(depsgraph, scene or depsgraph.scene_eval).read(camera, size)


class Geometries:
    """Meshes that were sent, kept from one read of a scene to the next (`sync.py`)."""

    def __init__(self) -> None:
        self._kept: dict[tuple[int, int, int], _Geometry | str] = {}  # of the read before
        self._met: dict[tuple[int, int, int], _Geometry | str] = {}  # in this one
        self._by_address: dict[int, _Geometry | str] = {}  # in this one

    def get(self, instance: Any, read: Callable[[Any], _Geometry | str]) -> _Geometry | str:
        """Of this instance, read now if it is not known."""
        obj = instance.object
        # The object behind an instance is a temporary whose address is used again; that of its mesh is not, within one
        # read. Between two reads it may be, so those that own the mesh stand beside it: another owner, another mesh.
        maker = instance.parent if _made_by_another(instance) else obj
        address = obj.data.as_pointer()
        key = (address, maker.original.session_uid, obj.original.session_uid)
        known = self._by_address.get(address)
        if known is None:
            known = self._kept.get(key)
            if known is None:
                known = read(obj)
            self._by_address[address] = known
        self._met[key] = known
        return known

    def forget(self, owners: set[int]) -> None:
        """Drops the meshes of these objects (session_uid of the originals)."""
        self._kept = {key: value for key, value in self._kept.items() if owners.isdisjoint(key[1:])}

    def end_read(self) -> None:
        """What the read that ends here did not meet is dropped."""
        self._kept, self._met, self._by_address = self._met, {}, {}

    def __len__(self) -> int:
        """Different meshes of the read before."""
        return len({id(value) for value in self._kept.values() if isinstance(value, _Geometry)})


@dataclass
class _Geometry:
    """A mesh that was sent, with what instances of it share."""

    mesh: Any  # core.Mesh
    arrays: MeshArrays
    count: int
    box: DoubleArray | None = None

    def corners(self) -> DoubleArray:
        """(8, 3): those of the local bounding box."""
        if self.box is None:
            low = self.arrays.positions.min(axis=0).astype(np.float64)
            high = self.arrays.positions.max(axis=0).astype(np.float64)
            self.box = np.where(_CORNERS, high, low)
        return self.box


_CORNERS = np.array([[(i >> axis) & 1 for axis in range(3)] for i in range(8)], dtype=bool)


def _placed_corners(geometry: _Geometry, world_from_local: DoubleArray) -> DoubleArray:
    corners: DoubleArray = geometry.corners() @ world_from_local[:3, :3].T + world_from_local[:3, 3]
    return corners


def _made_by_another(instance: Any) -> bool:
    """False for objects of their own, also where Blender shows the mesh of a curve or text as an instance of itself."""
    parent = instance.parent
    return bool(instance.is_instance and parent is not None and parent.original != instance.object.original)


@dataclass
class Reader:
    """One read of a depsgraph. What it met stays, for `sync.py` to change in place."""

    depsgraph: Any
    blender_scene: Any
    geometries: Geometries = field(default_factory=Geometries)
    space: Any | None = None  # a 3D viewport: its local view, local collections and object types count
    notes: Notes = field(default_factory=Notes)

    def __post_init__(self) -> None:
        import penumbra_core

        self.core = penumbra_core
        self.scene = penumbra_core.Scene()
        self.light_names: list[str] = []
        self.materials = materials.Reader(self.notes)
        self.seen: dict[int, tuple[_Geometry, DoubleArray]] = {}  # by the core's instance, with the transform
        self._boxes: DoubleArray | None = None  # (n, 8, 3) corners of all that is in `seen`, in its order
        self._box_of: dict[int, int] = {}  # the core's instance -> row of `_boxes`
        self.plain: dict[
            int, int
        ] = {}  # an object's session_uid -> its instance, where it is one instance as it stands
        self.makers: set[int] = set()  # objects that make instances of others
        self.lamps: dict[int, str] = {}  # a light object's session_uid -> name of its light
        self.counters: dict[tuple[str, str], int] = {}
        self.names: dict[str, None] = {}  # an ordered set
        self.light_set: dict[str, None] = {}
        self.triangles = 0
        self.objects = 0
        self.known_switches: dict[int, tuple[bool, bool, bool, bool]] = {}

    def read(self, camera: str | None, size: tuple[int, int] | None) -> SceneExport:
        for text in kept(self.blender_scene.get(NOTES_KEY)):
            self.notes.add(text)
        frame = read_frame(self.blender_scene, size)
        for instance in self.depsgraph.object_instances:
            self._instance(instance)
        world = self._world()
        camera_name = self._camera(camera, frame)
        if not self.light_names:
            self._default_light()
        self.scene.validate()
        self.geometries.end_read()
        return SceneExport(
            scene=self.scene,
            notes=self.notes.sentences(),
            lights=self.light_names,
            camera=camera_name,
            size=frame.size,
            triangles=self.triangles,
            frame=int(self.blender_scene.frame_current),
            objects=self.objects,
            meshes=len(self.geometries),
            instance_names=list(self.names),
            world=world,
        )

    # ---------------------------------------------------------------------------------------------- one instance

    def _instance(self, instance: Any) -> None:
        obj = instance.object
        # An instance knows only its original's place in local view; what counts is the object that makes it.
        if self.space is not None and not (instance.parent or obj).visible_in_viewport_get(self.space):
            return
        kind = obj.type
        if kind == "LIGHT":
            self._light(instance)
            return
        self._particles(instance)
        if kind in _SILENT_TYPES:
            return
        if not instance.show_self:
            return
        if kind != "MESH":
            what = kind.lower().replace("_", " ")
            self.notes.add(f"left out, {what} objects have no triangles", obj.name)
            return

        geometry = self._geometry(instance)
        if isinstance(geometry, str):
            if geometry:
                self.notes.add(geometry, obj.name)
            return
        world_from_local = matrix_of(instance.matrix_world)
        if is_singular(world_from_local):
            self.notes.add("left out, its transform flattens it or is not finite (a scale of 0?)", obj.name)
            return
        surfaces = self._surfaces(instance)
        if any(surface.emits for surface in surfaces) and self._emitter(instance, geometry, surfaces, world_from_local):
            return

        visible, casts, receives = self._switches(instance)
        if not (visible or casts):
            return
        self.scene.add_instance(
            self._name(instance),
            geometry.mesh,
            world_from_local,
            albedo=np.array([surface.albedo for surface in surfaces], dtype=np.float32),
            casts=casts,
            receives=receives,
            visible=visible,
        )
        self.objects += 1
        self.triangles += geometry.count
        number = self.objects - 1
        if visible:
            self.seen[number] = (geometry, world_from_local)
        if _made_by_another(instance):
            self.makers.add(instance.parent.original.session_uid)
        elif not instance.is_instance:
            self.plain[instance.object.original.session_uid] = number

    def _name(self, instance: Any) -> str:
        """The object's name; instances say what made them, and which of them they are."""
        name = instance.object.name
        if _made_by_another(instance):
            key = (instance.parent.name, name)
            self.counters[key] = self.counters.get(key, 0) + 1
            name = f"{key[0]} / {name} {self.counters[key]}"
        return self._unique(name, self.names)

    @staticmethod
    def _unique(name: str, taken: dict[str, None]) -> str:
        unique, number = name, 1
        while unique in taken:
            number += 1
            unique = f"{name} ({number})"
        taken[unique] = None
        return unique

    def _switches(self, instance: Any) -> tuple[bool, bool, bool]:
        """visible, casts, receives. An instance also obeys the object that makes it, as in Cycles."""
        visible, casts, hole, catcher = self._own_switches(instance.object)
        if _made_by_another(instance):
            parent = self._own_switches(instance.parent)
            visible, casts = visible and parent[0], casts and parent[1]
            hole, catcher = hole or parent[2], catcher or parent[3]
        if hole:
            self.notes.add("a holdout; it blocks light and view, its own pixels are not compared", instance.object.name)
        if catcher:
            self.notes.add("a shadow catcher; treated like any other surface", instance.object.name)
        return visible, casts, not hole

    def _own_switches(self, obj: Any) -> tuple[bool, bool, bool, bool]:
        """visible, casts, holdout, shadow catcher of one object, asked once."""
        key = obj.original.as_pointer()
        known = self.known_switches.get(key)
        if known is None:
            layer = self.depsgraph.view_layer_eval
            indirect = obj.indirect_only_get(view_layer=layer)
            holdout = bool(obj.is_holdout or obj.holdout_get(view_layer=layer))
            visible = bool(obj.visible_camera) and not indirect
            known = (visible, bool(obj.visible_shadow), holdout, bool(obj.is_shadow_catcher))
            self.known_switches[key] = known
        return known

    def _particles(self, instance: Any) -> None:
        if instance.is_instance:
            return
        for system in instance.object.particle_systems:
            kind = system.settings.render_type
            if kind in {"PATH", "HALO", "LINE"}:
                what = "hair" if kind == "PATH" else "particles"
                self.notes.add(f"left out, its {what} without triangles", instance.object.name)

    # ------------------------------------------------------------------------------------------------- geometry

    def _geometry(self, instance: Any) -> _Geometry | str:
        """The mesh of an instance, read and sent once; or why there is none ("" if that is no loss)."""
        return self.geometries.get(instance, self._read_geometry)

    def _read_geometry(self, obj: Any) -> _Geometry | str:
        # In edit mode the mesh holds what was there before; Blender must be asked for a copy of what is seen.
        convert = obj.mode == "EDIT"
        mesh = obj.to_mesh() if convert else obj.data
        try:
            arrays = read_mesh(mesh)
            vertices = len(mesh.vertices)
        finally:
            if convert:
                obj.to_mesh_clear()
        if arrays is None:
            return "left out, it has no faces" if vertices else ""
        if not arrays.finite:
            return "left out, its mesh holds positions that are not numbers"
        if arrays.corner_normals is not None and not np.isfinite(arrays.corner_normals.sum()):
            self.notes.add("shaded flat, its normals are not numbers", obj.name)
            arrays.corner_normals = None
        core_mesh = self.core.Mesh(
            obj.data.name,
            arrays.positions,
            arrays.triangles,
            corner_normals=arrays.corner_normals,
            triangle_material=arrays.triangle_material,
        )
        return _Geometry(core_mesh, arrays, len(arrays.triangles))

    def _surfaces(self, instance: Any) -> list[materials.Surface]:
        """One surface per material slot; at least one."""
        obj = instance.object
        data = obj.data
        slots: list[Any] = list(data.materials) if data is not None and hasattr(data, "materials") else []
        own_data = not _made_by_another(instance) or (
            instance.instance_object is not None
            and instance.instance_object.data is not None
            and data is not None
            and instance.instance_object.data.as_pointer() == data.as_pointer()
        )
        if own_data:
            for i, slot in enumerate(obj.material_slots):
                if i >= len(slots):
                    slots.append(slot.material)
                elif slot.link == "OBJECT":
                    slots[i] = slot.material
        return [self.materials.surface(material) for material in slots] or [materials.Surface(materials.GREY)]

    # --------------------------------------------------------------------------------------------------- lights

    def _add_light(self, light: Any, name: str) -> None:
        light.name = self._unique(name, self.light_set)
        self.scene.add_light(light)
        self.light_names.append(light.name)

    def _light(self, instance: Any) -> None:
        if not instance.show_self:
            return
        light = self.read_light(instance.object, instance.matrix_world)
        if light is None:
            return
        self._add_light(light, self._light_name(instance))
        if _made_by_another(instance):
            self.makers.add(instance.parent.original.session_uid)
        else:
            self.lamps[instance.object.original.session_uid] = light.name

    def read_light(self, obj: Any, matrix_world: Any) -> Any | None:
        """A light object as a core.Light without its final name; None, with a note, if it cannot shine."""
        data = obj.data
        matrix = matrix_of(matrix_world)
        if not np.isfinite(matrix).all():
            self.notes.add("left out, the light's transform is not finite", obj.name)
            return None
        if not obj.visible_diffuse:
            self.notes.add("left out, the light does not reach diffuse surfaces (ray visibility)", obj.name)
            return None
        nodes = self.materials.light_factor(data, obj.name)
        strength = float(data.energy) * compat.light_strength_factor(data, lights.normalising_area(data, matrix))
        power = np.array([strength * c * n for c, n in zip(compat.light_tint(data), nodes, strict=True)])
        if not np.isfinite(power).all() or power.min() < 0.0:
            self.notes.add("left out, the light's strength is negative or not a number", obj.name)
            return None
        if power.max() == 0.0:
            self.notes.add("left out, the light's strength or colour is 0", obj.name)
            return None

        light = self.core.Light()
        light.power_w = tuple(float(p) for p in power)
        light.position_ws = tuple(matrix[:3, 3])
        light.casts_shadow = compat.light_casts_shadow(data)
        if not self._shape(light, data, matrix):
            self.notes.add("left out, the light's transform leaves it no direction (a scale of 0?)", obj.name)
            return None
        if not light.casts_shadow:
            self.notes.add("the light's shadow is switched off; it lights everything", obj.name)
        if light.kind in {"point", "spot"} and light.radius_m > 0.0 and compat.has_soft_falloff(data):
            self.notes.add("soft falloff is ignored; within a few radii of the light, Cycles is darker", obj.name)
        linking = getattr(obj, "light_linking", None)
        if linking is not None and (linking.receiver_collection or linking.blocker_collection):
            self.notes.add("light linking is ignored; the light reaches everything", obj.name)
        return light

    def _light_name(self, instance: Any) -> str:
        if _made_by_another(instance):
            return f"{instance.parent.name} / {instance.object.name}"
        return str(instance.object.name)

    def _shape(self, light: Any, data: Any, matrix: DoubleArray) -> bool:
        """Kind, size and direction of a Blender light; False if its direction is undefined."""
        x, y, z = (matrix[:3, i] for i in range(3))
        if data.type == "POINT":
            light.kind = "point"
            light.radius_m = float(data.shadow_soft_size)
            return True
        if data.type == "AREA":
            direction = lights.area_direction(matrix)
            half_u, half_v = lights.area_axes(data, matrix)
            light.kind = "ellipse" if data.shape in {"DISK", "ELLIPSE"} else "rectangle"
            light.half_u_ws, light.half_v_ws = tuple(half_u), tuple(half_v)
            if data.spread < math.pi - 1e-4:
                self.notes.add("the area light's spread is ignored; it shines to all sides of its front", data.name)
        else:
            direction = unit(-z)
        if direction is None:
            return False
        light.direction_ws = tuple(direction)
        if data.type == "SUN":
            light.kind = "sun"
            light.sun_angle_rad = float(min(data.angle, math.pi))
        elif data.type == "SPOT":
            u, v = unit(x), unit(y)
            if u is None or v is None:
                return False
            light.kind = "spot"
            light.radius_m = float(data.shadow_soft_size)
            light.spot_angle_rad = float(data.spot_size)
            light.spot_blend = float(data.spot_blend)
            light.half_u_ws, light.half_v_ws = tuple(u), tuple(v)
            depth = float(np.linalg.norm(z))
            light.spot_stretch = (float(np.linalg.norm(x)) / depth, float(np.linalg.norm(y)) / depth)
            if data.use_square:
                self.notes.add("the spot's square cone is drawn round", data.name)
        return True

    def _emitter(
        self, instance: Any, geometry: _Geometry, surfaces: list[materials.Surface], matrix: DoubleArray
    ) -> bool:
        """Make a polygon light of an emissive object; False, with a note, if it must stay ordinary geometry."""
        name = instance.object.name
        used = (
            {0}
            if geometry.arrays.triangle_material is None
            else {min(int(i), len(surfaces) - 1) for i in np.unique(geometry.arrays.triangle_material)}
        )
        glowing = [surfaces[i] for i in sorted(used) if surfaces[i].emits]
        if not glowing:
            return False
        why = ""
        corners: DoubleArray | None = None
        if len(glowing) != len(used) or any(g.emission != glowing[0].emission for g in glowing):
            why = "only part of it glows, or not evenly"
        elif glowing[0].emission is None:
            why = "its emission comes from nodes that are not read"
        elif geometry.count > 4096:
            why = "it is too detailed"
        else:
            corners, why = lights.planar_outline(
                geometry.arrays.positions.astype(np.float64), geometry.arrays.triangles
            )
        if corners is None:
            self.notes.add(f"glows in Blender, but stays an ordinary surface: {why}", name)
            return False

        corners_ws = lights.facing_outline(corners, matrix)
        vector_area = lights.outline_vector_area(corners_ws)
        direction = unit(vector_area)
        emission = glowing[0].emission
        if direction is None or emission is None:
            return False
        light = self.core.Light()
        light.kind = "polygon"
        light.position_ws = tuple(corners_ws.mean(axis=0))
        light.direction_ws = tuple(direction)
        light.corners_ws = [tuple(c) for c in corners_ws]
        area = float(np.linalg.norm(vector_area))
        light.power_w = tuple(math.pi * area * e for e in emission)
        self.notes.add("a glowing flat mesh; taken as a light that shines to the side its normals point to", name)
        self._add_light(light, self._light_name(instance))
        return True

    def _world(self) -> materials.Colour:
        world = self.blender_scene.world
        radiance = materials.BLACK if world is None else self.materials.world_radiance(world)
        if radiance is None:
            self.notes.add("the world's light comes from nodes that are not read; it is ignored", world.name)
        elif max(radiance) > 0.0:
            self.notes.add("the world's light casts no shadow; comparisons ignore it", world.name)
        return radiance or materials.BLACK

    # --------------------------------------------------------------------------------------------------- camera

    def _camera(self, wanted: str | None, frame: Frame) -> str:
        obj = self._camera_object(wanted)
        camera = self.core.Camera()
        camera.width_px, camera.height_px = frame.size
        camera.pixel_aspect = frame.pixel_aspect
        if obj is None:
            self._place_camera(camera, frame)
            self.scene.camera = camera
            return str(camera.name)

        data = obj.data
        matrix = matrix_of(obj.matrix_world)
        if is_singular(matrix):
            raise BridgeError(f'camera "{obj.name}" has a transform that flattens it or is not finite; clear its scale')
        if data.type not in {"PERSP", "ORTHO"}:
            what = compat.panorama_name(data) if data.type == "PANO" else "custom"
            self.notes.add(f"its {what} projection is replaced by a perspective one of the same focal length", obj.name)
        if data.dof.use_dof:
            self.notes.add("its depth of field is ignored", obj.name)
        lens = read_lens(data, frame)
        camera.name = obj.name
        camera.world_from_camera = self._rigid(matrix)
        camera.orthographic = lens.orthographic
        if lens.orthographic:
            camera.half_width_m = lens.half_width
        else:
            camera.tan_half_width = lens.half_width
        camera.shift = lens.shift
        camera.near_m = max(float(data.clip_start), 1e-6)
        camera.far_m = max(float(data.clip_end), camera.near_m * 2.0)
        self.scene.camera = camera
        return str(obj.name)

    @staticmethod
    def _rigid(matrix: DoubleArray) -> DoubleArray:
        """The camera's frame without scale and shear. It keeps looking where it looked; a mirror stays a mirror."""
        z = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        y = matrix[:3, 1] - z * float(np.dot(matrix[:3, 1], z))
        y /= np.linalg.norm(y)
        x = np.cross(y, z)
        if float(np.dot(x, matrix[:3, 0])) < 0.0:
            x = -x
        rigid = np.eye(4)
        rigid[:3, 0], rigid[:3, 1], rigid[:3, 2], rigid[:3, 3] = x, y, z, matrix[:3, 3]
        return rigid

    def _camera_object(self, wanted: str | None) -> Any | None:
        if wanted is None:
            obj = self.blender_scene.camera
            if obj is not None and (obj.type != "CAMERA" or NOTES_KEY in obj):
                if obj.type != "CAMERA":
                    self.notes.add("the scene's camera is no camera object", obj.name)
                return None
            return obj
        cameras = sorted(o.name for o in self.blender_scene.objects if o.type == "CAMERA" and NOTES_KEY not in o)
        if wanted not in cameras:
            there = ", ".join(f'"{c}"' for c in cameras) or "none"
            raise BridgeError(f'there is no camera called "{wanted}"; the scene has {there}')
        return self.blender_scene.objects[wanted].evaluated_get(self.depsgraph)

    def move(self, number: int, world_from_local: DoubleArray) -> None:
        """An instance of the core's stands elsewhere."""
        self.scene.set_transform(number, np.ascontiguousarray(world_from_local))
        if number in self.seen:
            self.seen[number] = (self.seen[number][0], world_from_local)
            if self._boxes is not None:
                self._boxes[self._box_of[number]] = _placed_corners(*self.seen[number])

    def box_points(self) -> DoubleArray:
        """(n, 3) corners of the bounding boxes of all that is visible; of a cube round the origin if nothing is. The
        caller's own."""
        if not self.seen:
            return np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
        if self._boxes is None:
            self._boxes = np.stack([_placed_corners(geometry, matrix) for geometry, matrix in self.seen.values()])
            self._box_of = {number: row for row, number in enumerate(self.seen)}
        return self._boxes.reshape(-1, 3).copy()

    def _place_camera(self, camera: Any, frame: Frame) -> None:
        placed = placing.frame_everything(self.box_points(), frame)
        camera.name = "placed camera"
        camera.world_from_camera = placed.world_from_camera
        camera.tan_half_width = placed.tan_half_width
        camera.near_m, camera.far_m = placed.near_m, placed.far_m
        self.notes.add("there is no camera; one was placed that frames everything")

    def _default_light(self) -> None:
        eye = np.array(self.scene.camera.world_from_camera, dtype=np.float64)
        placed = placing.light_everything(self.box_points(), eye)
        light = self.core.Light()
        light.kind = "rectangle"
        light.position_ws, light.direction_ws = tuple(placed.position), tuple(placed.direction)
        light.half_u_ws, light.half_v_ws = tuple(placed.half_u), tuple(placed.half_v)
        light.power_w = (placed.power_w,) * 3
        self._add_light(light, "placed light")
        self.notes.add("there is no light; a square area light was placed above, to the left of the camera")
