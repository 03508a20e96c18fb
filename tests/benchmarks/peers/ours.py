"""Penumbra's techniques, and the truth that all are held against."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from . import exchange, visibility
from .exchange import SharedScene
from .visibility import Image, Mask
from .worker import Answer, timed

TRUTH_FILE = "truth.npz"
# Places in the pixel, a net in the unit square: what a box filter a pixel wide sees of a sharp edge.
PLACES = [((k + 0.5) / 16 - 0.5, (int(f"{k:04b}"[::-1], 2) + 0.5) / 16 - 0.5) for k in range(16)]
COARSER = 4.0  # the standard error at each place, over that of the truth at the centre: their mean has the same


class Ours:
    def __init__(self, folder: Path) -> None:
        import penumbra_core as core

        started = time.perf_counter()
        self._folder = folder
        self._shared = exchange.load(folder)
        self._renderer = core.Renderer(view_by="rays")
        self._renderer.set_scene(core_scene(core, self._shared))
        self._renderer.view()
        self._sync_ms = 1e3 * (time.perf_counter() - started)

    def facts(self) -> Answer:
        facts = dict(self._renderer.environment)
        return {"sync_ms": self._sync_ms, "version": facts.get("core", ""), "environment": facts}

    def truth(self, standard_error: float) -> Answer:
        """Writes the truth, at pixel centres and over whole pixels, the pixels compared and what is divided by."""
        raw, took = timed(lambda: self._renderer.reference(0, standard_error=standard_error, seed=1))
        view = self._renderer.view()
        normal = np.asarray(view.normal_ws)
        position = np.asarray(view.position_cr)
        position_ws = position.astype(np.float64) + np.asarray(view.eye_ws)
        unshadowed = np.asarray(self._renderer.irradiance(0))[..., 0]
        mask = np.asarray(raw["mask"]) != 0
        compared = mask & visibility.inside_surfaces(np.asarray(view.instance), normal, position)
        compared &= visibility.whole_light_above(self._shared.light, position_ws, normal)
        compared &= visibility.bright_enough(np.where(mask, unshadowed, 0))
        filtered, filtered_error, whole = self._filtered(view, COARSER * standard_error)
        compared &= whole
        partial = self._folder / f"partial_{TRUTH_FILE}"
        np.savez(
            partial,
            area=raw["area"],
            irradiance=raw["irradiance"],
            area_error=raw["standard_error"],
            irradiance_error=raw["irradiance_standard_error"],
            filtered=filtered,
            filtered_error=filtered_error,
            mask=compared.astype(np.uint8),
            unshadowed=unshadowed,
        )
        partial.replace(self._folder / TRUTH_FILE)
        return took | {"rays_per_pixel": float(raw["mean_rays_per_pixel"]), "pixels": int(compared.sum())}

    def _filtered(self, centre: Any, standard_error: float) -> tuple[Image, Image, Mask]:
        """The irradiance ratio over whole pixels and its standard error: the mean over places in the pixel; and where
        all of them see the surface that the pixel's centre sees.
        """
        import penumbra_core as core

        renderer, scene = core.Renderer(), core_scene(core, self._shared)
        values, squares, whole = [], [], np.ones(np.shape(centre.instance), bool)
        for seed, place in enumerate(PLACES):
            moved = scene.copy()
            camera = moved.camera
            camera.pixel_offset = place
            moved.camera = camera
            renderer.set_scene(moved)
            raw = renderer.reference(0, standard_error=standard_error, seed=2 + seed)
            values.append(np.asarray(raw["irradiance"], np.float64))
            squares.append(np.square(raw["irradiance_standard_error"], dtype=np.float64))
            view = renderer.view()
            whole &= np.asarray(view.instance) == np.asarray(centre.instance)
            turned = (np.asarray(view.normal_ws) * np.asarray(centre.normal_ws)).sum(axis=-1)
            whole &= turned >= visibility.SAME_SURFACE_COS
        error = np.sqrt(np.mean(squares, axis=0) / len(PLACES))
        return np.mean(values, axis=0).astype(np.float32), error.astype(np.float32), whole

    def jobs(self, sweep: str) -> Answer:
        """(technique, settings) of all techniques that serve the light, from the machinery of `penumbra compare`.

        "quick": three settings of each, and all of those that trace rays.
        """
        import penumbra_core as core
        from penumbra.compare import jobs_of

        every = core.techniques()
        wanted: list[dict[str, Any]] = []
        for info in every:
            if self._renderer.supports(0, info["id"]):
                continue
            found = jobs_of(info, {}, "full" if sweep == "full" or info["randomised"] else "quick")
            wanted += [{"technique": job.id, "settings": job.settings} for job in found]
        return {"jobs": wanted}

    def render(self, settings: dict[str, Any], out: str, seconds: float = 1.0) -> Answer:
        """A dynamic frame (casters moved: every map drawn anew) and the view; `static_ms` keeps the maps.

        Processor time: what the whole measuring took of it, in proportion.
        """
        job = (settings["technique"], settings["settings"])
        (measured,), whole = timed(
            lambda: self._renderer.measure(0, [job], max_seconds=seconds, min_runs=1, max_runs=3)
        )
        view, dynamic, static = (measured[key]["median"] for key in ("view", "dynamic", "static"))
        if out:
            picture = self._renderer.visibility(0, *job, statistics=False)["visibility"]
            np.save(out, np.asarray(picture, np.float32))
        return {
            "wall_ms": view + dynamic,
            "cpu_ms": (view + dynamic) * whole["cpu_ms"] / whole["wall_ms"],
            "view_ms": view,
            "static_ms": view + static,
            "setup_ms": measured["setup"]["median"],
        }


def core_scene(core: Any, shared: SharedScene) -> Any:
    scene = core.Scene()
    white = np.ones((1, 3), np.float32)
    for part in shared.parts:
        scene.add_instance(part.name, core.Mesh(part.name, part.positions, part.triangles), np.eye(4), white)
    light, given = core.Light(), shared.light
    light.name, light.kind = "light", given.kind
    light.position_ws, light.direction_ws = given.position, given.direction
    light.half_u_ws, light.half_v_ws = given.half_u, given.half_v
    light.sun_angle_rad = given.sun_angle_rad
    light.power_w = (given.power,) * 3
    scene.add_light(light)
    camera = core.Camera()
    camera.world_from_camera = np.asarray(shared.camera.world_from_camera)
    camera.tan_half_width = shared.camera.tan_half_width
    camera.near_m, camera.far_m = shared.camera.near_m, shared.camera.far_m
    camera.width_px, camera.height_px = shared.camera.width_px, shared.camera.height_px
    scene.camera = camera
    return scene
