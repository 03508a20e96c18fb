"""Inside Blender's window: which Embree answers to whom, and shadows with a known truth from our copy.

Arguments: the extension zip that brings the core wheel.
"""

from __future__ import annotations

import ctypes
import shutil
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parent), "/penumbra/addon"]
from in_window import play, take_picture  # noqa: E402

# A half plane at BLOCKER_M over the floor, its edge along y at x = 0; over that edge a square light, LIGHT_M high.
LIGHT_M, BLOCKER_M, HALF_SIDE_M = 3.0, 1.0, 0.5
PICTURE_M = 1.0  # width of what the camera sees
WIDTH, HEIGHT = 256, 128
STANDARD_ERROR = 0.004


class _Table(ctypes.Structure):
    """The head of embree_table.h's Table."""

    _fields_ = (
        ("table_version", ctypes.c_int),
        ("compiled_version", ctypes.c_int),
        ("new_device", ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p)),
        ("release_device", ctypes.CFUNCTYPE(None, ctypes.c_void_p)),
        ("loaded_version", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)),
    )


def global_version() -> int:
    """Of the Embree that any library of this process gets which does not ask for its own."""
    everybody = ctypes.CDLL(None)
    everybody.rtcNewDevice.restype = ctypes.c_void_p
    everybody.rtcGetDeviceProperty.restype = ctypes.c_ssize_t
    everybody.rtcGetDeviceProperty.argtypes = [ctypes.c_void_p, ctypes.c_int]
    everybody.rtcReleaseDevice.argtypes = [ctypes.c_void_p]
    device = everybody.rtcNewDevice(b"threads=1")
    version = int(everybody.rtcGetDeviceProperty(device, 0))
    everybody.rtcReleaseDevice(device)
    return version


def careless_version(plugin: Path) -> int:
    """Of the Embree that a copy of our plugin gets when it is opened like any other library."""
    copy = plugin.with_name("careless.so")
    shutil.copy(plugin, copy)
    library = ctypes.CDLL(str(copy))
    library.penumbra_embree_table.restype = ctypes.POINTER(_Table)
    table = library.penumbra_embree_table().contents
    device = table.new_device(b"threads=1")
    version = int(table.loaded_version(device))
    table.release_device(device)
    return version


def versions(answer: dict[str, Any]) -> None:
    answer["global_version"] = global_version()
    bpy.ops.extensions.package_install_files(filepath=sys.argv[-1], repo="user_default", enable_on_install=True)
    import penumbra_core as core

    plugin = Path(core.__file__).with_name("penumbra_embree.so")
    answer["core"] = core.__file__
    answer["embree_version"] = core.embree_version()
    answer["careless_version"] = careless_version(plugin)
    maps = Path("/proc/self/maps").read_text().splitlines()
    answer["libraries"] = sorted({line.split()[-1] for line in maps if "embree" in line or "libtbb" in line})


def make_scene() -> None:
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)

    def add(name: str, data: Any, z: float) -> Any:
        item = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(item)
        item.location = (0, 0, z)
        return item

    def rectangle(name: str, x0: float, x1: float, y: float, z: float) -> Any:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(x0, -y, 0), (x1, -y, 0), (x1, y, 0), (x0, y, 0)], [], [(0, 1, 2, 3)])
        return add(name, mesh, z)

    rectangle("Floor", -20, 20, 20, 0)
    rectangle("Blocker", -20, 0, 20, BLOCKER_M).visible_camera = False
    light = bpy.data.lights.new("Key", "AREA")
    light.shape, light.size, light.energy = "SQUARE", 2 * HALF_SIDE_M, 100
    add("Key", light, LIGHT_M)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", PICTURE_M
    bpy.context.scene.camera = add("Camera", camera, 5)
    bpy.context.view_layer.update()


def shadows(answer: dict[str, Any]) -> None:
    import penumbra_core as core
    from penumbra.bridge import read_scene

    make_scene()
    export = read_scene(bpy.context.evaluated_depsgraph_get(), size=(WIDTH, HEIGHT))
    renderer = core.Renderer()
    renderer.set_scene(export.scene)
    answer["device"] = renderer.environment
    reference = renderer.reference(0, standard_error=STANDARD_ERROR, max_rays_per_pixel=1 << 20)
    traced = np.asarray(reference["area"])
    exact = np.asarray(renderer.reference(0, exact=True)["area"])
    mapped = np.asarray(renderer.visibility(0, "shadow_map")["visibility"])

    # The part of the light on the open side of the plane through the pixel and the edge.
    x = ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * PICTURE_M
    edge = -x * (LIGHT_M / BLOCKER_M - 1)
    truth = np.clip((HALF_SIDE_M - edge) / (2 * HALF_SIDE_M), 0, 1)
    far_from_edge = np.abs(x) > 2 * PICTURE_M / WIDTH
    answer |= {
        "traced_rmse": float(np.sqrt(((traced - truth) ** 2).mean())),
        "traced_bias": float((traced - truth).mean()),
        "exact_max": float(np.abs(exact - truth).max()),
        "mapped_wrong": int((mapped != (x > 0))[:, far_from_edge].sum()),
        "pixels": traced.size,
    }
    show(traced, mapped)


def show(left: np.ndarray, right: np.ndarray) -> None:
    """Both pictures side by side in an image editor beside the 3D viewport."""
    values = np.ones((HEIGHT, 2 * WIDTH, 4), np.float32)
    values[..., :3] = np.hstack([left, right])[..., None]
    picture = bpy.data.images.new("Traced and mapped", 2 * WIDTH, HEIGHT)
    picture.pixels.foreach_set(values.ravel())
    screen = bpy.context.window_manager.windows[0].screen
    viewport = next(area for area in screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=viewport):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.4)
    editor = next(area for area in screen.areas if area.type == "VIEW_3D" and area != viewport)
    editor.type = "IMAGE_EDITOR"
    editor.spaces.active.image = picture


def fit(answer: dict[str, Any]) -> None:
    editor, region = _editor()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=editor, region=region):
        bpy.ops.image.view_all(fit_view=True)


def picture(answer: dict[str, Any]) -> None:
    _, region = _editor()
    screen_height = bpy.context.window_manager.windows[0].height

    def on_screen(u: float) -> tuple[int, int]:
        x, y = region.view2d.view_to_region(u, 0.5, clip=False)
        return region.x + x, screen_height - 1 - (region.y + y)

    # Lit and dark places of the traced picture (left half) and of the mapped one.
    answer["dark_px"] = [on_screen(0.05), on_screen(0.55)]
    answer["lit_px"] = [on_screen(0.45), on_screen(0.95)]
    take_picture("picture.png")


def _editor() -> tuple[Any, Any]:
    screen = bpy.context.window_manager.windows[0].screen
    editor = next(area for area in screen.areas if area.type == "IMAGE_EDITOR")
    return editor, next(region for region in editor.regions if region.type == "WINDOW")


play(versions, shadows, fit, picture)
