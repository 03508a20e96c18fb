"""Opens scenes: .blend files as they are, mesh files with a floor, a light and a camera put round them.

    scenes.open_scene("shot.blend")
    export = scenes.read(camera="Camera.001", size=(640, 360))

Every failure is a SceneError with one sentence. Blender's own chatter on the terminal is caught; where it explains a
failure it goes into the sentence.
"""

from __future__ import annotations

import contextlib
import ctypes
import gzip
import io
import math
import os
import re
import sys
import tempfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from . import compat
from .bridge import NOTES_KEY, BridgeError, SceneExport, read_scene
from .read.transforms import DoubleArray

T = TypeVar("T")

MESH_SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf", ".usd", ".usda", ".usdc", ".usdz")
SUFFIXES = (".blend", *MESH_SUFFIXES)

FLOOR = "Penumbra floor"
KEY_LIGHT = "Penumbra key"
CAMERA = "Penumbra camera"

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_GZIP_MAGIC = b"\x1f\x8b"


class SceneError(Exception):
    """A scene cannot be opened or read; one sentence that says what, where and what to do."""


def import_bpy() -> Any:
    """Blender as a Python module, or SceneError with the way to get it."""
    try:
        import bpy
    except ImportError as error:
        # Where one of its libraries does not load, the error names the module, too.
        if isinstance(error, ModuleNotFoundError) and error.name == "bpy":
            raise SceneError("Blender's Python module is not installed; run: pip install 'penumbra[bpy]'") from error
        raise SceneError(f"Blender's Python module is installed but does not load: {error}") from error
    if compat.too_old(bpy.app.version):
        wanted = ".".join(str(n) for n in compat.MINIMUM_BLENDER[:2])
        raise SceneError(f"this is Blender {bpy.app.version_string}; Penumbra needs {wanted} or newer")
    return bpy


@contextlib.contextmanager
def quiet() -> Iterator[Callable[[], str]]:
    """Catch what C and Python code print to the terminal; yields a function that returns the text afterwards.

    Works on the file descriptors, because most of Blender's messages never pass through sys.stdout, and on sys.stdout,
    because those of operators do, and it may be another stream.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    _flush_c()
    with tempfile.TemporaryFile() as sink:
        saved: list[tuple[int, int]] = []
        for descriptor in (1, 2):
            with contextlib.suppress(OSError):  # a descriptor may be closed
                saved.append((descriptor, os.dup(descriptor)))

        printed: list[str] = []
        told = io.StringIO()
        try:
            for descriptor, _ in saved:
                os.dup2(sink.fileno(), descriptor)
            with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
                yield lambda: "".join(printed)
        finally:
            printed.append(told.getvalue())
            _flush_c()
            size = os.fstat(sink.fileno()).st_size
            printed.append(os.pread(sink.fileno(), size, 0).decode("utf-8", "replace"))
            for descriptor, copy in saved:
                os.dup2(copy, descriptor)
                os.close(copy)


def _flush_c() -> None:
    """Empty the C library's buffers: into a pipe or a file it writes late, and so to the wrong place."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).fflush(None)


def open_scene(path: str | os.PathLike[str]) -> Any:
    """Open a scene file and return its active bpy scene. Whatever was open before is closed without saving.

    Scripts in the file are not run. A mesh file is imported into an empty scene and gets a floor just below it, and a
    light and a camera where the file brings none; units and the up axis are the importer's business.
    """
    file = Path(path)
    _check_path(file)
    bpy = import_bpy()
    if file.suffix.lower() == ".blend":
        _open_blend(bpy, file)
    else:
        _import_mesh(bpy, file)
    return bpy.context.scene


def read(
    *,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    frame: int | None = None,
    view_layer: str | None = None,
) -> SceneExport:
    """Export the scene that is open, as a final render would see it, at a frame (the current one by default)."""
    bpy = import_bpy()
    scene = bpy.context.scene
    if camera is not None:
        cameras = sorted(o.name for o in scene.objects if o.type == "CAMERA")
        if camera not in cameras:
            there = ", ".join(f'"{c}"' for c in cameras) or "none"
            raise SceneError(f'there is no camera called "{camera}"; the scene has {there}')
    with quiet():
        if frame is not None:
            scene.frame_set(frame)
        try:
            return render_depsgraph(
                scene, lambda depsgraph: read_scene(depsgraph, camera=camera, size=size), view_layer=view_layer
            )
        except BridgeError as error:
            raise SceneError(str(error)) from error


def render_depsgraph(scene: Any, use: Callable[[Any], T], *, view_layer: str | None = None) -> T:
    """Call `use` with the depsgraph of a final render of the scene's current frame, and return its result.

    Blender gives Python only the viewport's depsgraph, which knows nothing of the render switches: hidden in render,
    render levels of modifiers, instances of the final render. A render engine is handed the right one, so we register
    one for the moment, render with it, and unregister it: a class left behind hangs Blender's module at exit.
    """
    bpy = import_bpy()
    layer = view_layer or bpy.context.view_layer.name
    if layer not in scene.view_layers:
        there = ", ".join(f'"{name}"' for name in scene.view_layers.keys())  # noqa: SIM118
        raise SceneError(f'there is no view layer called "{layer}"; the scene has {there}')
    caught: dict[str, Any] = {}

    def render(self: Any, depsgraph: Any) -> None:
        try:
            caught["result"] = use(depsgraph)
        except BaseException as error:  # Blender would print it and go on
            caught["error"] = error

    name = "PENUMBRA_READER"
    engine = type(
        name,
        (bpy.types.RenderEngine,),
        {"bl_idname": name, "bl_label": "Penumbra reader", "bl_use_postprocess": False, "render": render},
    )
    bpy.utils.register_class(engine)
    try:
        with _prepared(bpy, scene, name):
            bpy.ops.render.render(write_still=False, scene=scene.name, layer=layer)
    except RuntimeError as error:
        if not caught:
            raise SceneError(f"Blender cannot render this scene: {_last_line(str(error))}") from error
    finally:
        bpy.utils.unregister_class(engine)
    if "error" in caught:
        raise caught["error"]
    if "result" not in caught:
        raise SceneError(f'Blender rendered nothing of view layer "{layer}"; is it switched off for rendering?')
    result: T = caught["result"]
    return result


@contextlib.contextmanager
def _prepared(bpy: Any, scene: Any, engine: str) -> Iterator[None]:
    """Settings that make Blender's render call only gather the scene; all of them are put back."""
    render = scene.render
    wanted = {"engine": engine, "use_compositing": False, "use_sequencer": False, "use_persistent_data": False}
    before = {key: getattr(render, key) for key in wanted}
    placed = None
    try:
        for key, value in wanted.items():
            setattr(render, key, value)
        if scene.camera is None or scene.camera.type != "CAMERA":
            placed = _stand_in_camera(bpy, scene)
        yield
    finally:
        for key, value in before.items():
            setattr(render, key, value)
        if placed is not None:
            camera, previous = placed
            data = camera.data
            scene.camera = previous
            bpy.data.objects.remove(camera)
            bpy.data.cameras.remove(data)


def _stand_in_camera(bpy: Any, scene: Any) -> tuple[Any, Any]:
    """Blender renders nothing without a camera; this one is marked, so that the bridge does not take it for real."""
    previous = scene.camera
    camera = bpy.data.objects.new(CAMERA + " (stand-in)", bpy.data.cameras.new(CAMERA + " (stand-in)"))
    camera[NOTES_KEY] = "stand-in"
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera, previous


# ------------------------------------------------------------------------------------------------------------ opening


def _check_path(file: Path) -> None:
    if not file.exists():
        raise SceneError(f'"{file}" does not exist')
    if not file.is_file():
        raise SceneError(f'"{file}" is not a file')
    if file.suffix.lower() not in SUFFIXES:
        what = f'ends in "{file.suffix}"' if file.suffix else "has no ending"
        raise SceneError(f'"{file}" {what}; Penumbra opens {", ".join(SUFFIXES)}')
    if not os.access(file, os.R_OK):
        raise SceneError(f'"{file}" may not be read; change its permissions')
    if file.stat().st_size == 0:
        raise SceneError(f'"{file}" is empty')


def _last_line(text: str) -> str:
    """The last line of Blender's message, without its prefixes and its full stop."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    line = lines[-1] if lines else "no reason given"
    line = re.sub(r"^(Error|Warning|RuntimeError|Report)\s*:\s*", "", line)
    return line.rstrip(".!")


def blend_version(file: Path) -> tuple[int, int] | None:
    """The Blender version that wrote a .blend file, or None if the header cannot be read (e.g. zstd-compressed)."""
    with open(file, "rb") as stream:
        head = stream.read(32)
    if head.startswith(_GZIP_MAGIC):
        with contextlib.suppress(OSError, EOFError, zlib.error), gzip.open(file, "rb") as packed:
            head = packed.read(32)
    elif head.startswith(_ZSTD_MAGIC):
        with contextlib.suppress(Exception):
            import zstandard  # comes with Blender

            with open(file, "rb") as stream, zstandard.ZstdDecompressor().stream_reader(stream) as packed_z:
                head = packed_z.read(32)
    # "BLENDER-v405" until 4.5, "BLENDER17-01v0500" from 5.0.
    match = re.match(rb"BLENDER(?:[_-][vV](\d)(\d\d)|\d\d-\d\d[vV](\d\d)(\d\d))", head)
    if match is None:
        return None
    major, minor = (match[1], match[2]) if match[1] is not None else (match[3], match[4])
    return int(major), int(minor)


def _open_blend(bpy: Any, file: Path) -> None:
    version = blend_version(file)
    own = tuple(bpy.app.version[:2])
    newer = version is not None and version > own
    complaint = ""
    try:
        with quiet() as printed:
            _close(bpy)
            # use_scripts=False: a file that is only looked at must not run code.
            bpy.ops.wm.open_mainfile(filepath=str(file.resolve()), load_ui=False, use_scripts=False)
    except (RuntimeError, UnicodeDecodeError) as error:
        complaint = _reason(str(error), printed(), file)
        if _is_open(bpy, file):  # Blender found damage, reported it, and opened the rest
            pass
        elif newer and version is not None:
            raise SceneError(
                f'"{file}" was saved by Blender {version[0]}.{version[1]}; '
                f"this is Blender {own[0]}.{own[1]}, which cannot open it: use a newer one"
            ) from error
        else:
            raise SceneError(f'Blender cannot open "{file}": {complaint}') from error
    if not _is_open(bpy, file):
        raise SceneError(f'Blender cannot open "{file}": {_reason("", printed(), file)}')
    notes = []
    if complaint:
        notes.append(f"Blender found the file damaged and opened the rest: {complaint}")
    if newer and version is not None:
        notes.append(
            f"saved by Blender {version[0]}.{version[1]}, newer than this {own[0]}.{own[1]}; some of it may be lost"
        )
    if notes:
        bpy.context.scene[NOTES_KEY] = notes
    if not any(o.type in {"MESH", "CURVE", "SURFACE", "FONT", "META", "EMPTY"} for o in bpy.context.scene.objects):
        raise SceneError(f'"{file}" holds nothing to draw: its scene "{bpy.context.scene.name}" has no mesh')


def _close(bpy: Any) -> None:
    """An empty scene without a file; keeps the user's preferences and add-ons, unlike read_factory_settings."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)


def _is_open(bpy: Any, file: Path) -> bool:
    return bool(bpy.data.filepath) and Path(bpy.data.filepath) == file.resolve()


def _reason(raised: str, printed: str, file: Path) -> str:
    """The telling line of Blender's message, without the path that the sentence names anyway."""
    line = _last_line(raised if raised.strip() else printed)
    return re.sub(
        r'\s*(in file|in|file|File)?\s*[\'"]?' + re.escape(str(file.resolve())) + r'[\'"]?:?\s*', " ", line
    ).strip()


def _import_mesh(bpy: Any, file: Path) -> None:
    suffix = file.suffix.lower()
    path = str(file.resolve())
    printed: Callable[[], str]
    try:
        with quiet() as printed:
            _close(bpy)
            if suffix == ".obj":
                bpy.ops.wm.obj_import(filepath=path)
            elif suffix == ".ply":
                bpy.ops.wm.ply_import(filepath=path)
            elif suffix == ".stl":
                bpy.ops.wm.stl_import(filepath=path)
            elif suffix in {".glb", ".gltf"}:
                compat.ensure_gltf_importer(bpy)
                bpy.ops.import_scene.gltf(filepath=path)
            else:
                bpy.ops.wm.usd_import(filepath=path)
    except (RuntimeError, UnicodeDecodeError, AttributeError) as error:
        raise SceneError(f'Blender cannot import "{file}": {_reason(str(error), printed(), file)}') from error
    box = _bounding_box(bpy)
    if box is None:
        lines = [line for line in printed().splitlines() if "error" in line.lower()]
        because = f" ({_last_line(lines[-1])})" if lines else ""
        raise SceneError(f'"{file}" holds no mesh with faces{because}')
    _furnish(bpy, *box)


def _bounding_box(bpy: Any) -> tuple[DoubleArray, DoubleArray] | None:
    """World-space bounds of everything with faces, or None."""
    lows, highs = [], []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        obj = instance.object
        if obj.type != "MESH" or len(obj.data.polygons) == 0:
            continue
        corners = np.array([list(corner) for corner in obj.bound_box], dtype=np.float64)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        world = corners @ matrix[:3, :3].T + matrix[:3, 3]
        if np.isfinite(world).all():
            lows.append(world.min(axis=0))
            highs.append(world.max(axis=0))
    if not lows:
        return None
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _furnish(bpy: Any, low: DoubleArray, high: DoubleArray) -> None:
    """A floor just below, an area light to the upper left, a camera at the front right; sized to the mesh."""
    scene = bpy.context.scene
    diameter = max(float(np.linalg.norm(high - low)), 1e-6)
    centre = (low + high) / 2.0
    ground = float(low[2]) - 1e-3 * diameter
    placed = ["a floor"]

    half = 2.0 * diameter
    corners = [(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)]
    mesh = bpy.data.meshes.new(FLOOR)
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    floor = bpy.data.objects.new(FLOOR, mesh)
    floor.location = (centre[0], centre[1], ground)
    scene.collection.objects.link(floor)

    if not any(o.type == "LIGHT" for o in scene.objects):
        away = np.array([-0.55, -0.35, 1.0])
        away /= np.linalg.norm(away)
        distance = 1.2 * diameter
        data = bpy.data.lights.new(KEY_LIGHT, "AREA")
        data.shape = "SQUARE"
        data.size = 0.35 * diameter
        # Irradiance of about 3 W/m^2 at the middle of the mesh: a white surface shows a value close to 1.
        data.energy = 3.0 * math.pi * distance**2
        light = bpy.data.objects.new(KEY_LIGHT, data)
        _look(light, centre + distance * away, centre)
        scene.collection.objects.link(light)
        placed.append("an area light")

    if scene.camera is None:
        cameras = [o for o in scene.objects if o.type == "CAMERA"]
        if cameras:
            scene.camera = cameras[0]
    if scene.camera is None:
        data = bpy.data.cameras.new(CAMERA)
        view = np.array([0.5, -0.8, 0.55])
        view /= np.linalg.norm(view)
        render = scene.render
        aspect = min(1.0, render.resolution_y / max(render.resolution_x, 1))
        # The mesh with the shadow beside it fills the frame's shorter side.
        distance = 0.75 * diameter / math.sin(math.atan(0.5 * data.sensor_width / data.lens * aspect))
        data.clip_start = distance * 0.05
        data.clip_end = distance + 8.0 * diameter
        camera = bpy.data.objects.new(CAMERA, data)
        aim = np.array([centre[0], centre[1], ground + 0.4 * (high[2] - ground)])
        _look(camera, aim + distance * view, aim)
        scene.collection.objects.link(camera)
        scene.camera = camera
        placed.append("a camera")

    said = placed[0] if len(placed) == 1 else ", ".join(placed[:-1]) + " and " + placed[-1]
    where = "were put round it" if len(placed) > 1 else "was put under it"
    scene[NOTES_KEY] = [f"a mesh file; {said} {where}"]
    bpy.context.view_layer.update()


def _look(obj: Any, place: DoubleArray, target: DoubleArray) -> None:
    """Stand at `place` and look along -z at `target`, with +y up."""
    from mathutils import Vector

    obj.location = tuple(place)
    obj.rotation_euler = Vector(tuple(target - place)).to_track_quat("-Z", "Y").to_euler()
