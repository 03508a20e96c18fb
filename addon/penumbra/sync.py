"""A core.Scene that follows Blender's: what changed is read again, the rest stays.

An object that moved costs its matrix, a light itself; a changed mesh is read with the list of instances, all other
meshes staying as they are. Blender says what changed (`depsgraph.updates`); where that is not understood, everything is
read, with the meshes that nobody touched kept.
"""

from __future__ import annotations

from typing import Any

from . import bridge
from .read.transforms import is_singular, matrix_of

# Data-blocks whose changes do not reach a picture, or reach it through objects that are told of too.
_UNSEEN = frozenset(
    {"Scene", "Camera", "ViewLayer", "WindowManager", "Screen", "WorkSpace", "Text", "Brush", "Palette"}
)


class SceneSync:
    """One viewport's scene."""

    def __init__(self) -> None:
        self._geometries = bridge.Geometries()
        self._reader: bridge.Reader | None = None
        self._export: bridge.SceneExport | None = None
        self._shown: tuple[Any, ...] = ()
        self.full_reads = 0

    @property
    def export(self) -> bridge.SceneExport | None:
        """What the last update() left; its scene is changed by the next one: hand copies on."""
        return self._export

    @property
    def box_points(self) -> Any:
        """(n, 3) corners of the boxes of all that is visible."""
        assert self._reader is not None
        return self._reader.box_points()

    def update(self, depsgraph: Any, space: Any | None = None) -> bridge.SceneExport:
        """
        space: the 3D viewport whose own choice of objects counts: local view, local collections, types of objects
        @raises BridgeError, penumbra_core.InvalidScene; the next update() then reads everything
        """
        if space is None:
            shown: tuple[Any, ...] = tuple(obj.as_pointer() for obj in depsgraph.objects)
        else:
            shown = tuple((obj.as_pointer(), obj.visible_in_viewport_get(space)) for obj in depsgraph.objects)
        export, self._export = self._export, None
        if export is None or shown != self._shown or not self._patch(depsgraph):
            export = self._read(depsgraph, space)
        self._shown, self._export = shown, export
        return export

    def _read(self, depsgraph: Any, space: Any | None) -> bridge.SceneExport:
        changed = set()
        for update in depsgraph.updates:
            if update.is_updated_geometry:
                changed.add(update.id.original.session_uid)
                data = getattr(update.id, "data", None)
                if data is not None and hasattr(data, "original"):
                    changed.add(data.original.session_uid)
        if self._reader is None or changed:
            self._geometries.forget(changed)
        self._reader = bridge.Reader(depsgraph, depsgraph.scene_eval, self._geometries, space=space)
        self.full_reads += 1
        return self._reader.read(None, None)

    def _patch(self, depsgraph: Any) -> bool:
        """Changes in place what moved. False if more than that happened, with nothing changed."""
        reader = self._reader
        assert reader is not None
        moved: list[tuple[int, Any]] = []
        lit: dict[str, Any] = {}
        lights_data: dict[int, Any] = {}
        trees = set()
        for update in depsgraph.updates:
            kind = update.id.bl_rna.identifier
            if kind == "Object":
                place = self._object(reader, update)
                if place is False:
                    return False
                if isinstance(place, str):
                    lit[place] = update.id
                elif place is not None:
                    moved.append((place, update.id))
            elif "Light" in kind and "Probe" not in kind:
                lights_data[update.id.original.session_uid] = update.id.original
            elif "NodeTree" in kind:
                trees.add(update.id.original.as_pointer())
            elif kind not in _UNSEEN or update.is_updated_geometry:
                return False
        # Lights are read with their nodes; what else has nodes is read with everything.
        if trees - {light.node_tree.as_pointer() for light in lights_data.values() if light.node_tree}:
            return False
        if lights_data:
            for obj in depsgraph.objects:
                if obj.type == "LIGHT" and obj.data.original.session_uid in lights_data:
                    name = reader.lamps.get(obj.original.session_uid)
                    if name is None:
                        return False
                    lit[name] = obj
        return self._apply(reader, moved, lit)

    @staticmethod
    def _object(reader: bridge.Reader, update: Any) -> int | str | bool | None:
        """What an object's update asks for: its instance, its light's name, None for nothing, False for a full read."""
        obj = update.id
        uid = obj.original.session_uid
        if obj.type in {"CAMERA", "SPEAKER"}:
            return None
        if uid in reader.makers:
            return False
        if obj.type == "LIGHT":
            return reader.lamps.get(uid, False)
        if update.is_updated_geometry or update.is_updated_shading:
            return False
        if not update.is_updated_transform:
            return None
        if obj.type == "MESH":
            return reader.plain.get(uid, False)
        # Empties and armatures show nothing themselves; what hangs on them has updates of its own.
        return None if obj.type in {"EMPTY", "ARMATURE", "LATTICE"} else False

    @staticmethod
    def _apply(reader: bridge.Reader, moved: list[tuple[int, Any]], lit: dict[str, Any]) -> bool:
        matrices = [(number, matrix_of(obj.matrix_world)) for number, obj in moved]
        if any(is_singular(matrix) for _, matrix in matrices):
            return False
        made = {}
        for name, obj in lit.items():
            light = reader.read_light(obj, obj.matrix_world)
            if light is None:
                return False
            light.name = name
            made[name] = light
        for number, matrix in matrices:
            reader.move(number, matrix)
        if made:
            reader.scene.lights = [made.get(light.name, light) for light in reader.scene.lights]
        return True
