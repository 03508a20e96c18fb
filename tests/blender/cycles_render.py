"""Renders a bpy scene's direct diffuse light with Cycles, without albedo: irradiance over pi, at pixel centres."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from image_files import choose_multilayer_exr


def direct_diffuse(
    bpy: Any, *, samples: int, seed: int = 0, shadows: bool = True
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]:
    """The pass "Diffuse Direct" of the open scene and the object index of every pixel (0 where nothing is seen).

    Shapes (height, width, 3) and (height, width), first row at the bottom. The filter is a hundredth of a
    pixel, so that every sample sees the pixel's centre, as the core's view does.
    """
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.seed = seed
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    # Cycles gives a box filter the width of a pixel whatever is asked for; the others obey.
    cycles.pixel_filter_type = "GAUSSIAN"
    cycles.filter_width = 0.01
    cycles.max_bounces = 0
    cycles.use_light_tree = False
    cycles.sample_clamp_direct = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.blur_glossy = 0.0
    layer = bpy.context.view_layer
    layer.use_pass_diffuse_direct = True
    layer.use_pass_diffuse_color = True
    layer.use_pass_object_index = True
    if not shadows:
        for obj in scene.objects:
            obj.visible_shadow = False
    choose_multilayer_exr(scene.render.image_settings)
    scene.render.use_compositing = False
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "direct")
        bpy.ops.render.render(write_still=True)
        return _read(Path(folder) / "direct.exr", layer.name)


def _read(path: Path, layer: str) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]:
    import OpenEXR

    channels: dict[str, Any] = {}
    with OpenEXR.File(str(path), separate_channels=True) as image:
        for part in image.parts:
            channels.update({name: channel.pixels for name, channel in part.channels.items()})

    def pick(channel: str, *names: str) -> npt.NDArray[np.float32]:
        for name in names:
            for key in (f"{layer}.{name}.{channel}", f"{name}.{channel}"):
                if key in channels:
                    values: npt.NDArray[np.float32] = np.flipud(channels[key]).astype(np.float32)
                    return values
        raise KeyError(f"{names} not among {sorted(channels)}")

    # The names up to 4.5, and from 5.0 on.
    rgb = np.stack([pick(c, "DiffDir", "Diffuse Direct") for c in "RGB"], axis=-1)
    return rgb, pick("X", "IndexOB", "Object Index").round().astype(np.int32)
