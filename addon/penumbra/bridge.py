"""From Blender to the core: an evaluated depsgraph in, a `penumbra_core.Scene` out.

This is the one file that turns Blender's data into the core's. It reads in bulk (no Python loop over vertices), sends
a mesh once however many instances show it, and writes down by name whatever it leaves out, places or approximates.

Conventions: world space is Blender's, metres, z up. A light's watts are Blender's own; the core turns them into
radiance. Matrices are float64 and map from local to world.
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import compat, materials
from .notes import Notes

FloatArray = npt.NDArray[np.float32]
DoubleArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int32]

GREY = (0.8, 0.8, 0.8)  # Blender's surface without a material
MAX_LIGHT_CORNERS = 8
NOTES_KEY = "penumbra_notes"  # custom property of a scene: what `scenes.open_scene` put there

# Objects that never become triangles and are no loss.
_SILENT_TYPES = frozenset(
    {"EMPTY", "CAMERA", "LIGHT", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE", "LIGHTPROBE"}
)
_CONVERTED_TYPES = frozenset({"CURVE", "SURFACE", "FONT", "META"})


class BridgeError(Exception):
    """Something of the Blender scene cannot be exported at all; one sentence."""


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
    return _Reader(depsgraph, scene or depsgraph.scene_eval).read(camera, size)


@dataclass
class MeshArrays:
    """Triangles of one evaluated mesh in its own space, as the core takes them."""

    positions: FloatArray  # (n, 3)
    triangles: npt.NDArray[np.uint32]  # (m, 3)
    corner_normals: FloatArray | None = None  # (3 m, 3)
    triangle_material: npt.NDArray[np.uint16] | None = None  # (m,)

    @property
    def finite(self) -> bool:
        # min and max carry a NaN through, and cost less than an isfinite array.
        return bool(np.isfinite(self.positions.min()) and np.isfinite(self.positions.max()))


# ---------------------------------------------------------------------------------------------------------- meshes


def triangle_corners_slow(mesh: Any) -> IndexArray:
    """Corner indices of all triangles, flat, by the documented way (150 ms for a million triangles)."""
    corners = np.empty(len(mesh.loop_triangles) * 3, dtype=np.int32)
    mesh.loop_triangles.foreach_get("loops", corners)
    return corners


def triangle_corners_fast(mesh: Any) -> IndexArray | None:
    """The same through the address of the first triangle (1 ms), or None where the memory is not what we expect.

    Blender keeps three int32 per triangle, one triangle after the other. That is no promise of its API, so the stride
    is measured and some triangles are compared with what the API says; all of them are compared in the tests.
    """
    loop_triangles = mesh.loop_triangles
    count = len(loop_triangles)
    if count < 2:
        return None
    address = loop_triangles[0].as_pointer()
    stride = 3 * ctypes.sizeof(ctypes.c_int32)
    if loop_triangles[count - 1].as_pointer() - address != stride * (count - 1):
        return None
    shared = np.ctypeslib.as_array((ctypes.c_int32 * (3 * count)).from_address(address))
    corners: IndexArray = shared.copy()
    if corners.min() < 0 or corners.max() >= len(mesh.loops):
        return None
    for i in {0, 1, count // 3, count // 2, (2 * count) // 3, count - 1}:
        if tuple(loop_triangles[i].loops) != tuple(corners[3 * i : 3 * i + 3]):
            return None
    return corners


def _read_attribute(
    mesh: Any, name: str, key: str, fallback: tuple[Any, str], shape: int, dtype: type
) -> npt.NDArray[Any]:
    """A whole attribute by its internal name (1 ms), or the documented collection where the name is unknown (20 ms+)."""
    attribute = mesh.attributes.get(name)
    source, field_name = (attribute.data, key) if attribute is not None else fallback
    values = np.empty(len(source) * shape, dtype=dtype)
    source.foreach_get(field_name, values)
    return values


def read_mesh(mesh: Any, *, fast: bool = True) -> MeshArrays | None:
    """All triangles of an evaluated mesh, or None if it has none. fast=False takes the documented ways only."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners = triangle_corners_fast(mesh) if fast else None
    if corners is None:
        corners = triangle_corners_slow(mesh)

    if fast:
        positions = _read_attribute(mesh, "position", "vector", (mesh.vertices, "co"), 3, np.float32)
        corner_vertex = _read_attribute(mesh, ".corner_vert", "value", (mesh.loops, "vertex_index"), 1, np.int32)
    else:
        positions = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
        mesh.vertices.foreach_get("co", positions)
        corner_vertex = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get("vertex_index", corner_vertex)
    triangles = np.take(corner_vertex, corners).reshape(-1, 3).view(np.uint32)

    normals: FloatArray | None = None
    if compat.has_smooth_normals(mesh):
        per_corner = np.empty(len(mesh.loops) * 3, dtype=np.float32)
        mesh.corner_normals.foreach_get("vector", per_corner)
        normals = np.take(per_corner.reshape(-1, 3), corners, axis=0)

    material: npt.NDArray[np.uint16] | None = None
    if mesh.attributes.get("material_index") is not None:
        per_face = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.attributes["material_index"].data.foreach_get("value", per_face)
        if per_face.any():
            face = np.empty(count, dtype=np.int32)
            mesh.loop_triangle_polygons.foreach_get("value", face)
            material = np.take(per_face, face).clip(0, 65535).astype(np.uint16)
    return MeshArrays(positions.reshape(-1, 3), triangles, normals, material)


def _matrix(blender_matrix: Any) -> DoubleArray:
    return np.array(blender_matrix, dtype=np.float64)


def _singular(world_from_local: DoubleArray) -> bool:
    """True for a transform that is not finite or flattens space, judged apart from its overall scale."""
    linear = world_from_local[:3, :3]
    if not np.isfinite(world_from_local).all():
        return True
    lengths = np.linalg.norm(linear, axis=0)
    if lengths.min() == 0.0:
        return True
    return bool(abs(np.linalg.det(linear / lengths)) < 1e-7)


# ---------------------------------------------------------------------------------------------------------- lights


def _unit(vector: DoubleArray) -> DoubleArray | None:
    length = float(np.linalg.norm(vector))
    if not math.isfinite(length) or length == 0.0:
        return None
    return vector / length


def emitting_area(light: Any, world_from_local: DoubleArray) -> float:
    """The area by which Blender divides a light's energy when it normalises; m^2, for a sun the projected solid angle."""
    if light.type == "SUN":
        return math.pi * math.sin(min(light.angle, math.pi) / 2.0) ** 2
    if light.type in {"POINT", "SPOT"}:
        return math.pi * light.shadow_soft_size**2
    u, v = _area_axes(light, world_from_local)
    area = 4.0 * float(np.linalg.norm(np.cross(u, v)))
    return area * math.pi / 4.0 if light.shape in {"DISK", "ELLIPSE"} else area


def _area_axes(light: Any, world_from_local: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """From the centre to the edge along local x and y; the object's scale multiplies the light's size."""
    size_y = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    return world_from_local[:3, 0] * (light.size / 2.0), world_from_local[:3, 1] * (size_y / 2.0)


def area_direction(world_from_local: DoubleArray) -> DoubleArray | None:
    """Unit normal of an area light's plane on the side that local -z points to; None if the plane is undefined."""
    x, y, z = (world_from_local[:3, i] for i in range(3))
    normal = _unit(np.cross(x, y))
    if normal is None:  # a light squeezed to a line or a point still knows where it looks
        return _unit(-z)
    return -normal if float(np.dot(normal, z)) > 0.0 or not np.any(z) else normal


def planar_outline(positions: DoubleArray, triangles: npt.NDArray[np.uint32]) -> tuple[DoubleArray | None, str]:
    """The corners of a flat convex patch of triangles, counter-clockwise seen from where the triangles face.

    Returns (corners, "") or (None, why not). Corners that lie on a straight edge or inside are dropped.
    """
    points = positions[triangles.astype(np.int64)]
    vector_area = 0.5 * np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    area = float(np.linalg.norm(vector_area, axis=1).sum())
    if area <= 0.0 or not math.isfinite(area):
        return None, "it has no area"
    total = vector_area.sum(axis=0)
    used = positions[np.unique(triangles)]
    extent = float(np.linalg.norm(used.max(axis=0) - used.min(axis=0)))
    normal = _unit(total)
    if normal is None:
        return None, "it is not flat"
    if np.ptp(used @ normal) > 1e-4 * extent or float(np.linalg.norm(total)) < area * (1.0 - 1e-4):
        return None, "it is not flat"

    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(axis, normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    flat = np.unique(np.column_stack((used @ u, used @ v)), axis=0)
    hull = _convex_hull(flat, 1e-5 * extent)
    if len(hull) < 3 or len(hull) > MAX_LIGHT_CORNERS:
        return None, f"it has more than {MAX_LIGHT_CORNERS} corners" if len(hull) > 3 else "it has no area"
    x, y = hull[:, 0], hull[:, 1]
    hull_area = 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    if abs(hull_area - area) > 1e-3 * hull_area:
        return None, "it is not convex"
    height = float((used @ normal).mean())
    return hull[:, :1] * u + hull[:, 1:] * v + height * normal, ""


def _convex_hull(points: DoubleArray, tolerance: float) -> DoubleArray:
    """Counter-clockwise hull (monotone chain) of points sorted by x then y, without points within tolerance of an edge."""

    def chain(sequence: DoubleArray) -> list[DoubleArray]:
        hull: list[DoubleArray] = []
        for point in sequence:
            while len(hull) > 1:
                edge, step = hull[-1] - hull[-2], point - hull[-2]
                span = math.hypot(*step)
                if span > 0.0 and edge[0] * step[1] - edge[1] * step[0] > tolerance * span:
                    break
                hull.pop()
            hull.append(point)
        return hull[:-1]

    if len(points) < 3:
        return points
    return np.array(chain(points) + chain(points[::-1]))


# ---------------------------------------------------------------------------------------------------------- camera


@dataclass(frozen=True)
class Frame:
    """The picture to be taken: pixels of the whole frame, the pixel's shape, and the part that is wanted."""

    width: int
    height: int
    pixel_aspect: float = 1.0  # height of a pixel over its width
    border: tuple[int, int, int, int] | None = None  # left, bottom, right, top in pixels

    @property
    def size(self) -> tuple[int, int]:
        left, bottom, right, top = self.border or (0, 0, self.width, self.height)
        return right - left, top - bottom


def read_frame(scene: Any, size: tuple[int, int] | None = None) -> Frame:
    """Resolution, percentage, pixel aspect and render border of a scene, rounded as Blender rounds them."""
    render = scene.render
    if size is not None:
        width, height = int(size[0]), int(size[1])
        if width < 1 or height < 1:
            raise BridgeError(f"the picture's size is {width} x {height} pixels; it must be at least 1 x 1")
    else:
        width = max(1, render.resolution_x * render.resolution_percentage // 100)
        height = max(1, render.resolution_y * render.resolution_percentage // 100)
    border = None
    if render.use_border:
        left, right = (int(np.float32(f) * width) for f in (render.border_min_x, render.border_max_x))
        bottom, top = (int(np.float32(f) * height) for f in (render.border_min_y, render.border_max_y))
        if right > left and top > bottom:
            border = (left, bottom, right, top)
    return Frame(width, height, render.pixel_aspect_y / render.pixel_aspect_x, border)


@dataclass
class Lens:
    """A camera in the core's words, for one frame."""

    orthographic: bool
    half_width: float  # at distance 1, or in metres where orthographic
    shift: tuple[float, float]  # of the picture's centre, in picture widths


def read_lens(camera: Any, frame: Frame) -> Lens:
    """Blender's lens and sensor for one frame: `BKE_camera_params_compute_viewplane` said in the core's words."""
    across, up = float(frame.width), float(frame.height) * frame.pixel_aspect  # both in pixel widths
    fit = camera.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if across >= up else "VERTICAL"
    fitted = across if fit == "HORIZONTAL" else up
    # The sensor's height counts only where the fit is set to vertical by hand.
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width

    orthographic = camera.type == "ORTHO"
    extent = camera.ortho_scale if orthographic else sensor / camera.lens
    per_pixel = extent / fitted
    centre_x, centre_y = camera.shift_x * fitted, camera.shift_y * fitted  # in pixel widths
    if frame.border is not None:
        left, bottom, right, top = frame.border
        centre_x += (left + right - frame.width) / 2.0
        centre_y += (bottom + top - frame.height) / 2.0 * frame.pixel_aspect
    width = frame.size[0]
    return Lens(orthographic, per_pixel * width / 2.0, (centre_x / width, centre_y / width))


# ---------------------------------------------------------------------------------------------------------- reader


@dataclass
class _Geometry:
    """A mesh that was sent, with what instances of it share."""

    mesh: Any  # core.Mesh
    arrays: MeshArrays
    count: int
    bounds: tuple[DoubleArray, DoubleArray] | None = None

    def corners(self) -> DoubleArray:
        """The eight corners of the local bounding box."""
        if self.bounds is None:
            self.bounds = (
                self.arrays.positions.min(axis=0).astype(np.float64),
                self.arrays.positions.max(axis=0).astype(np.float64),
            )
        low, high = self.bounds
        return np.array([[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)])


@dataclass
class _Reader:
    depsgraph: Any
    blender_scene: Any
    notes: Notes = field(default_factory=Notes)

    def __post_init__(self) -> None:
        import penumbra_core

        self.core = penumbra_core
        self.scene = penumbra_core.Scene()
        self.light_names: list[str] = []
        self.geometry: dict[Any, _Geometry | str] = {}
        self.materials = materials.Reader(self.notes)
        self.world_boxes: list[DoubleArray] = []
        self.counters: dict[tuple[str, str], int] = {}
        self.names: set[str] = set()
        self.light_set: set[str] = set()
        self.triangles = 0
        self.objects = 0
        self.camera_hidden: dict[int, tuple[bool, bool, bool, bool]] = {}

    def read(self, camera: str | None, size: tuple[int, int] | None) -> SceneExport:
        for text in self.blender_scene.get(NOTES_KEY, ()):
            self.notes.add(str(text))
        frame = read_frame(self.blender_scene, size)
        for instance in self.depsgraph.object_instances:
            self._instance(instance)
        self._world()
        camera_name = self._camera(camera, frame)
        if not self.light_names:
            self._default_light()
        self.scene.validate()
        meshes = sum(1 for g in self.geometry.values() if isinstance(g, _Geometry))
        return SceneExport(
            scene=self.scene,
            notes=self.notes.sentences(),
            lights=self.light_names,
            camera=camera_name,
            size=frame.size,
            triangles=self.triangles,
            frame=int(self.blender_scene.frame_current),
            objects=self.objects,
            meshes=meshes,
        )

    # ---------------------------------------------------------------------------------------------- one instance

    def _instance(self, instance: Any) -> None:
        obj = instance.object
        kind = obj.type
        if kind == "LIGHT":
            self._light(instance)
            return
        self._particles(instance)
        if kind in _SILENT_TYPES:
            return
        if not instance.show_self:
            return
        if kind != "MESH" and kind not in _CONVERTED_TYPES:
            what = kind.lower().replace("_", " ")
            self.notes.add(f"left out, {what} objects have no triangles", obj.name)
            return

        geometry = self._geometry(instance)
        if isinstance(geometry, str):
            if geometry:
                self.notes.add(geometry, obj.name)
            return
        world_from_local = _matrix(instance.matrix_world)
        if _singular(world_from_local):
            self.notes.add("left out, its transform flattens it or is not finite (a scale of 0?)", obj.name)
            return
        surfaces = self._surfaces(instance)
        if any(surface.emits for surface in surfaces) and self._emitter(
            instance, geometry, surfaces, world_from_local
        ):
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
        if visible:
            self.world_boxes.append(geometry.corners() @ world_from_local[:3, :3].T + world_from_local[:3, 3])

    def _name(self, instance: Any) -> str:
        """The object's name; instances say what made them, and which of them they are."""
        name = instance.object.name
        if instance.is_instance and instance.parent is not None:
            key = (instance.parent.name, name)
            self.counters[key] = self.counters.get(key, 0) + 1
            name = f"{key[0]} / {name} {self.counters[key]}"
        return self._unique(name, self.names)

    @staticmethod
    def _unique(name: str, taken: set[str]) -> str:
        unique, number = name, 1
        while unique in taken:
            number += 1
            unique = f"{name} ({number})"
        taken.add(unique)
        return unique

    def _switches(self, instance: Any) -> tuple[bool, bool, bool]:
        """visible, casts, receives. An instance also obeys the object that makes it, as in Cycles."""
        visible, casts, hole, catcher = self._own_switches(instance.object)
        if instance.is_instance and instance.parent is not None:
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
        known = self.camera_hidden.get(key)
        if known is None:
            layer = self.depsgraph.view_layer_eval
            indirect = obj.indirect_only_get(view_layer=layer)
            holdout = bool(obj.is_holdout or obj.holdout_get(view_layer=layer))
            visible = bool(obj.visible_camera) and not indirect
            known = (visible, bool(obj.visible_shadow), holdout, bool(obj.is_shadow_catcher))
            self.camera_hidden[key] = known
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
        obj = instance.object
        source = instance.instance_object if instance.is_instance else obj
        # The object behind an instance is a temporary whose address is used again; its data and its source are not.
        data_key = obj.data.as_pointer() if obj.data is not None else 0
        key = data_key if obj.type == "MESH" else (source.as_pointer(), data_key, obj.type)
        known = self.geometry.get(key)
        if known is None:
            known = self._read_geometry(obj)
            self.geometry[key] = known
        return known

    def _read_geometry(self, obj: Any) -> _Geometry | str:
        convert = obj.type != "MESH" or obj.mode == "EDIT"
        try:
            mesh = obj.to_mesh() if convert else obj.data
        except RuntimeError:
            mesh = None  # "Object does not have geometry data"
        try:
            if mesh is None:
                return ""
            arrays = read_mesh(mesh)
            name = obj.data.name if obj.data is not None else obj.name
        finally:
            if convert:
                obj.to_mesh_clear()
        if arrays is None:
            return "" if convert or len(mesh.vertices) == 0 else "left out, it has no faces"
        if not arrays.finite:
            return "left out, its mesh holds positions that are not numbers"
        if arrays.corner_normals is not None and not np.isfinite(arrays.corner_normals.sum()):
            self.notes.add("shaded flat, its normals are not numbers", obj.name)
            arrays.corner_normals = None
        core_mesh = self.core.Mesh(
            name,
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
        own_data = not instance.is_instance or (
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
        return [self.materials.surface(material) for material in slots] or [materials.Surface(GREY)]

    # --------------------------------------------------------------------------------------------------- lights

    def _add_light(self, light: Any, name: str) -> None:
        light.name = self._unique(name, self.light_set)
        self.scene.add_light(light)
        self.light_names.append(light.name)

    def _light(self, instance: Any) -> None:
        if not instance.show_self:
            return
        obj = instance.object
        data = obj.data
        matrix = _matrix(instance.matrix_world)
        if not np.isfinite(matrix).all():
            self.notes.add("left out, the light's transform is not finite", obj.name)
            return
        if not obj.visible_diffuse:
            self.notes.add("left out, the light does not reach diffuse surfaces (ray visibility)", obj.name)
            return
        nodes = self.materials.light_factor(data, obj.name)
        strength = float(data.energy) * compat.light_strength_factor(data, emitting_area(data, matrix))
        power = np.array([strength * c * n for c, n in zip(compat.light_tint(data), nodes, strict=True)])
        if not np.isfinite(power).all() or power.min() < 0.0:
            self.notes.add("left out, the light's strength is negative or not a number", obj.name)
            return
        if power.max() == 0.0:
            self.notes.add("left out, the light's strength or colour is 0", obj.name)
            return

        light = self.core.Light()
        light.power_w = tuple(float(p) for p in power)
        light.position_ws = tuple(matrix[:3, 3])
        light.casts_shadow = compat.light_casts_shadow(data)
        if not self._shape(light, data, matrix):
            self.notes.add("left out, the light's transform leaves it no direction (a scale of 0?)", obj.name)
            return
        if not light.casts_shadow:
            self.notes.add("the light's shadow is switched off; it lights everything", obj.name)
        linking = getattr(obj, "light_linking", None)
        if linking is not None and (linking.receiver_collection or linking.blocker_collection):
            self.notes.add("light linking is ignored; the light reaches everything", obj.name)
        self._add_light(light, self._light_name(instance))

    def _light_name(self, instance: Any) -> str:
        if instance.is_instance and instance.parent is not None:
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
            direction = area_direction(matrix)
            half_u, half_v = _area_axes(data, matrix)
            light.kind = "ellipse" if data.shape in {"DISK", "ELLIPSE"} else "rectangle"
            light.half_u_ws, light.half_v_ws = tuple(half_u), tuple(half_v)
            if data.spread < math.pi - 1e-4:
                self.notes.add("the area light's spread is ignored; it shines to all sides of its front", light_label(data))
        else:
            direction = _unit(-z)
        if direction is None:
            return False
        light.direction_ws = tuple(direction)
        if data.type == "SUN":
            light.kind = "sun"
            light.sun_angle_rad = float(min(data.angle, math.pi))
        elif data.type == "SPOT":
            u, v = _unit(x), _unit(y)
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
                self.notes.add("the spot's square cone is drawn round", light_label(data))
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
            corners, why = planar_outline(geometry.arrays.positions.astype(np.float64), geometry.arrays.triangles)
        if corners is None:
            self.notes.add(f"glows in Blender, but stays an ordinary surface: {why}", name)
            return False

        corners_ws = corners @ matrix[:3, :3].T + matrix[:3, 3]
        # Blender's normal of a mirrored object is the transformed normal, not the normal of the transformed corners.
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            corners_ws = corners_ws[::-1]
        centre = corners_ws.mean(axis=0)
        around = np.roll(corners_ws, -1, axis=0)
        vector_area = 0.5 * np.cross(corners_ws - centre, around - centre).sum(axis=0)
        area = float(np.linalg.norm(vector_area))
        direction = _unit(vector_area)
        if direction is None:
            return False
        light = self.core.Light()
        light.kind = "polygon"
        light.position_ws = tuple(centre)
        light.direction_ws = tuple(direction)
        light.corners_ws = [tuple(c) for c in corners_ws]
        assert glowing[0].emission is not None
        light.power_w = tuple(math.pi * area * e for e in glowing[0].emission)
        self.notes.add("a glowing flat mesh; taken as a light that shines to the side its normals point to", name)
        self._add_light(light, self._light_name(instance))
        return True

    def _world(self) -> None:
        world = self.blender_scene.world
        if world is not None and self.materials.world_shines(world):
            self.notes.add("the world's light is ignored", world.name)

    # --------------------------------------------------------------------------------------------------- camera

    def _camera(self, wanted: str | None, frame: Frame) -> str:
        obj = self._camera_object(wanted)
        camera = self.core.Camera()
        camera.width_px, camera.height_px = frame.size
        camera.pixel_aspect = frame.pixel_aspect
        if obj is None:
            self._place_camera(camera, frame)
            camera.name = "placed camera"
            self.scene.camera = camera
            return str(camera.name)

        data = obj.data
        matrix = _matrix(obj.matrix_world)
        if _singular(matrix):
            raise BridgeError(f'camera "{obj.name}" has a transform that flattens it or is not finite; clear its scale')
        if data.type not in {"PERSP", "ORTHO"}:
            what = compat.panorama_name(data) if data.type == "PANO" else "custom"
            self.notes.add(f"its {what} projection is replaced by a perspective one of the same focal length", obj.name)
        if data.dof.use_dof:
            self.notes.add("its depth of field is ignored", obj.name)
        lens = read_lens(data, frame)
        camera.name = obj.name
        camera.world_from_camera = self._rigid(matrix, obj.name)
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

    def _rigid(self, matrix: DoubleArray, name: str) -> DoubleArray:
        """The camera's frame without scale and shear: it keeps looking where it looked."""
        z = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        y = matrix[:3, 1] - z * float(np.dot(matrix[:3, 1], z))
        y /= np.linalg.norm(y)
        x = np.cross(y, z)
        if float(np.dot(x, matrix[:3, 0])) < 0.0:
            self.notes.add("the camera is mirrored; its picture is shown the right way round", name)
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

    def _box_points(self) -> DoubleArray:
        if not self.world_boxes:
            return np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
        return np.concatenate(self.world_boxes)

    def _place_camera(self, camera: Any, frame: Frame) -> None:
        """Frame everything: seen from the front right and above, 50 mm on 36 mm, 5 % air at the tightest edge.

        The rule looks only at the bounding boxes of what is visible, so the same scene gets the same camera.
        """
        points = self._box_points()
        centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
        z = np.array([0.45, -0.77, 0.45])
        z /= np.linalg.norm(z)
        x = np.cross([0.0, 0.0, 1.0], z)
        x /= np.linalg.norm(x)
        y = np.cross(z, x)
        tan_wide = 36.0 / 2.0 / 50.0
        across, up = float(frame.size[0]), frame.size[1] * frame.pixel_aspect
        tan_x, tan_y = tan_wide * across / max(across, up), tan_wide * up / max(across, up)
        local = (points - centre) @ np.column_stack((x, y, z))
        air = 0.95
        distance = float(
            np.maximum(
                local[:, 2] + np.abs(local[:, 0]) / (air * tan_x), local[:, 2] + np.abs(local[:, 1]) / (air * tan_y)
            ).max()
        )
        depth = float(np.ptp(local[:, 2]))
        distance = max(distance, float(local[:, 2].max()) + 1e-3 * max(depth, 1e-6))
        near = distance - float(local[:, 2].max())
        camera.world_from_camera = np.vstack(
            (np.column_stack((x, y, z, centre + distance * z)), np.array([0.0, 0.0, 0.0, 1.0]))
        )
        camera.tan_half_width = tan_x
        camera.near_m = max(near * 0.5, 1e-3 * (distance + depth))
        camera.far_m = (distance + depth) * 4.0
        self.notes.add("there is no camera; one was placed that frames everything")

    def _default_light(self) -> None:
        """A square of a quarter of the scene's diameter, one diameter away, above and to the camera's left."""
        points = self._box_points()
        low, high = points.min(axis=0), points.max(axis=0)
        centre = (low + high) / 2.0
        diameter = max(float(np.linalg.norm(high - low)), 1e-6)
        eye = np.array(self.scene.camera.world_from_camera, dtype=np.float64)
        left = -eye[:3, 0] * np.array([1.0, 1.0, 0.0])
        towards = np.array([0.0, 0.0, 1.0]) + 0.5 * (_unit(left) if _unit(left) is not None else np.zeros(3))
        towards /= np.linalg.norm(towards)
        u = np.cross([0.0, 1.0, 0.0], towards)
        u /= np.linalg.norm(u)
        v = np.cross(towards, u)
        light = self.core.Light()
        light.kind = "rectangle"
        light.position_ws = tuple(centre + diameter * towards)
        light.direction_ws = tuple(-towards)
        light.half_u_ws, light.half_v_ws = tuple(u * diameter / 8.0), tuple(v * diameter / 8.0)
        # Irradiance of about 3 W/m^2 at the centre: a white surface then shows a value close to 1.
        watts = 3.0 * math.pi * diameter**2
        light.power_w = (watts, watts, watts)
        self._add_light(light, "placed light")
        self.notes.add("there is no light; a square area light was placed above, to the left of the camera")


def light_label(data: Any) -> str:
    return str(data.name)
