"""Blender's own renderers, Cycles and EEVEE, through its Python module."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from . import exchange
from .visibility import Image, visibility
from .worker import Answer, timed

EEVEE_UNSHADOWED_SAMPLES = 8


class Blender:
    """The shared scene in an empty file: one white matte material, black world."""

    def __init__(self, folder: Path) -> None:
        import bpy

        started = time.perf_counter()
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._bpy = bpy
        self._folder = folder
        self._shared = exchange.load(folder)
        self._scene = bpy.context.scene
        self._fill()
        self._settings()
        self._fill_ms = 1e3 * (time.perf_counter() - started)

    def _fill(self) -> None:
        bpy = self._bpy
        world = bpy.data.worlds.new("black")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        self._scene.world = world
        white = bpy.data.materials.new("white")
        white.use_nodes = True
        white.node_tree.nodes.clear()
        diffuse = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
        output = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
        white.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
        for part in self._shared.parts:
            mesh = bpy.data.meshes.new(part.name)
            mesh.from_pydata(part.positions, [], part.triangles)
            mesh.shade_flat()
            mesh.materials.append(white)
            obj = bpy.data.objects.new(part.name, mesh)
            obj.shadow_terminator_geometry_offset = obj.shadow_terminator_shading_offset = 0.0
            self._scene.collection.objects.link(obj)
        self._light = self._add_light()
        given = self._shared.camera
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.sensor_fit = "HORIZONTAL"
        camera.data.angle = 2 * math.atan(given.tan_half_width)
        camera.data.clip_start, camera.data.clip_end = given.near_m, given.far_m
        camera.matrix_world = _matrix(given.world_from_camera)
        self._scene.collection.objects.link(camera)
        self._scene.camera = camera

    def _add_light(self) -> Any:
        given = self._shared.light
        data = self._bpy.data.lights.new("light", "SUN" if given.kind == "sun" else "AREA")
        data.energy = given.power
        z = -np.asarray(given.direction)
        if given.kind == "sun":
            data.angle = given.sun_angle_rad
            x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        else:
            u, v = np.asarray(given.half_u), np.asarray(given.half_v)
            data.shape = "RECTANGLE" if given.kind == "rectangle" else "ELLIPSE"
            data.size, data.size_y = 2 * np.linalg.norm(u), 2 * np.linalg.norm(v)
            x = u
        x = x / np.linalg.norm(x)
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack([x, np.cross(z, x), z], axis=-1)
        matrix[:3, 3] = given.position
        light = self._bpy.data.objects.new("light", data)
        light.matrix_world = _matrix(matrix)
        self._scene.collection.objects.link(light)
        return light

    def _settings(self) -> None:
        render = self._scene.render
        render.resolution_x, render.resolution_y = self._shared.camera.width_px, self._shared.camera.height_px
        render.resolution_percentage = 100
        render.use_persistent_data = True
        render.use_compositing = render.use_sequencer = False
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"

    def _render(self) -> Answer:
        _, took = timed(lambda: self._bpy.ops.render.render(write_still=False))
        return took

    def _irradiance(self) -> Image:
        """Of the picture rendered last; row 0 at the bottom."""
        import OpenEXR

        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "picture.exr")
            self._bpy.data.images["Render Result"].save_render(path, scene=self._scene)
            with OpenEXR.File(path, separate_channels=True) as image:
                red = image.channels()["R"].pixels
        return (np.flipud(red) * math.pi).astype(np.float32)


class Cycles(Blender):
    """Direct light of N samples a pixel; sample pattern, denoiser's passes and the like as Blender ships them."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._scene.render.engine = "CYCLES"
        cycles = self._scene.cycles
        cycles.device = "CPU"
        cycles.max_bounces = 0
        cycles.sample_clamp_direct = 0.0
        cycles.light_sampling_threshold = 0.0
        cycles.use_light_tree = False
        cycles.pixel_filter_type = "BOX"  # with antialiased edges the denoiser does better
        from .ours import TRUTH_FILE

        with np.load(folder / TRUTH_FILE) as truth:
            self._unshadowed = truth["unshadowed"]
        self._set({"samples": 1})
        first, again = self._render(), self._render()
        self._sync_ms = first["wall_ms"] - again["wall_ms"]

    def facts(self) -> Answer:
        return {"sync_ms": self._sync_ms, "version": self._bpy.app.version_string}

    def _set(self, settings: dict[str, Any]) -> None:
        cycles = self._scene.cycles
        cycles.samples = settings["samples"]
        cycles.use_adaptive_sampling = "threshold" in settings
        if "threshold" in settings:
            cycles.adaptive_threshold = settings["threshold"]
            cycles.adaptive_min_samples = 0
        cycles.use_denoising = "denoise" in settings
        if "denoise" in settings:
            cycles.denoiser = "OPENIMAGEDENOISE"
            cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
            quality, prefilter = settings["denoise"]
            cycles.denoising_quality, cycles.denoising_prefilter = quality, prefilter
            cycles.denoising_use_gpu = False

    def render(self, settings: dict[str, Any], out: str) -> Answer:
        self._set(settings)
        took = self._render()
        if out:
            np.save(out, visibility(self._irradiance(), self._unshadowed))
        return took


class Eevee(Blender):
    """N samples with default shadow settings. Divided by its own picture without shadows, which has no noise: its area
    lights are fits, which shall not count as errors of the shadow.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._scene.render.engine = "BLENDER_EEVEE_NEXT"
        self._scene.render.filter_size = 0.01
        self._scene.eevee.light_threshold = 1e-6
        self._light.data.use_shadow = False
        self._scene.eevee.taa_render_samples = 1
        first = self._render()  # makes its shaders, which is counted nowhere
        self._scene.eevee.taa_render_samples = EEVEE_UNSHADOWED_SAMPLES
        self._render()
        self._unshadowed = self._irradiance()
        self._light.data.use_shadow = True
        self._scene.eevee.taa_render_samples = 1
        self._render()
        self._first_ms = first["wall_ms"]

    def facts(self) -> Answer:
        return {"sync_ms": self._first_ms, "version": self._bpy.app.version_string}

    def render(self, settings: dict[str, Any], out: str) -> Answer:
        self._light.data.use_shadow_jitter = settings["jitter"]
        self._scene.eevee.taa_render_samples = settings["samples"]
        took = self._render()
        if out:
            np.save(out, visibility(self._irradiance(), self._unshadowed))
        return took


def _matrix(rows: Any) -> Any:
    from mathutils import Matrix

    return Matrix([[float(x) for x in row] for row in rows])
