"""Mitsuba 3, whole pictures at once through Dr.Jit and LLVM."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np

from . import exchange
from .exchange import SharedScene
from .visibility import visibility
from .worker import Answer, timed

VARIANT = "llvm_ad_mono"
SUN_DISTANCE = 1e5  # in radii of the scene: directions to it differ by less than 1e-5


class Mitsuba:
    """Direct light alone, one shadow ray for each of N samples."""

    def __init__(self, folder: Path) -> None:
        import drjit
        import mitsuba

        mitsuba.set_variant(VARIANT)
        self._mi, self._dr = mitsuba, drjit
        self._shared = exchange.load(folder)
        started = time.perf_counter()
        self._scene = mitsuba.load_dict(self._description())
        drjit.sync_thread()
        self._load_ms = 1e3 * (time.perf_counter() - started)
        self._integrator = mitsuba.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
        from .ours import TRUTH_FILE

        with np.load(folder / TRUTH_FILE) as truth:
            self._unshadowed = truth["unshadowed"]
        self._warm: set[int] = set()

    def facts(self) -> Answer:
        return {"sync_ms": self._load_ms, "version": f"{self._mi.__version__}, Dr.Jit {self._dr.__version__}"}

    def _description(self) -> dict[str, Any]:
        mi, shared = self._mi, self._shared
        positions, triangles = shared.soup()
        mesh = mi.Mesh("soup", len(positions), len(triangles), props=_flat_white(mi))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = positions.ravel()
        parameters["faces"] = triangles.ravel()
        parameters.update()
        given = shared.camera
        # Its cameras look along +z, with x to the left.
        turned = np.asarray(given.world_from_camera) @ np.diag([-1.0, 1.0, -1.0, 1.0])
        sensor = {
            "type": "perspective",
            "fov_axis": "x",
            "fov": math.degrees(2 * math.atan(given.tan_half_width)),
            "near_clip": given.near_m,
            "far_clip": given.far_m,
            "to_world": mi.ScalarTransform4f(turned),
            "film": {
                "type": "hdrfilm",
                "width": given.width_px,
                "height": given.height_px,
                "pixel_format": "luminance",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "multijitter"},
        }
        return {"type": "scene", "mesh": mesh, "light": self._emitter(shared), "sensor": sensor}

    def _emitter(self, shared: SharedScene) -> dict[str, Any]:
        """Radiance follows from the power as in Blender: watts over pi times area; for suns, W/m2 at right angles."""
        light = shared.light
        z = np.asarray(light.direction)
        matrix = np.eye(4)
        if light.kind == "sun":
            positions, _ = shared.soup()
            centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
            distance = SUN_DISTANCE * float(np.linalg.norm(positions.max(axis=0) - centre))
            radius = distance * math.tan(light.sun_angle_rad / 2)
            x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
            x /= np.linalg.norm(x)
            u, v = radius * x, radius * np.cross(z, x)
            matrix[:3, 3] = centre - distance * z
            radiance = light.power / (math.pi * math.sin(light.sun_angle_rad / 2) ** 2)
        else:
            u, v = np.asarray(light.half_u), np.asarray(light.half_v)
            if np.dot(np.cross(u, v), z) < 0:
                v = -v
            matrix[:3, 3] = light.position
            area = (4.0 if light.kind == "rectangle" else math.pi) * float(np.linalg.norm(np.cross(u, v)))
            radiance = light.power / (math.pi * area)
        matrix[:3, :3] = np.stack([u, v, z], axis=-1)
        return {
            "type": "rectangle" if light.kind == "rectangle" else "disk",
            "to_world": self._mi.ScalarTransform4f(matrix),
            "emitter": {"type": "area", "radiance": float(radiance)},
        }

    def render(self, settings: dict[str, Any], out: str) -> Answer:
        samples = settings["samples"]

        def work() -> Any:
            picture = self._mi.render(self._scene, integrator=self._integrator, spp=samples, seed=1)
            self._dr.eval(picture)
            self._dr.sync_thread()
            return picture

        if samples not in self._warm:  # compiles its kernel, which is counted nowhere
            work()
            self._warm.add(samples)
        picture, took = timed(work)
        if out:
            irradiance = np.flipud(np.asarray(picture)[..., 0]) * math.pi
            np.save(out, visibility(irradiance.astype(np.float32), self._unshadowed))
        return took


def _flat_white(mi: Any) -> Any:
    properties = mi.Properties()
    properties["face_normals"] = True
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 1.0}})
    return properties
