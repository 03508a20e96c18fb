"""How long a report takes to write, and what a Python call into the core costs beyond its work.

    python tests/benchmarks/report_bench.py [--runs N]

The report has two lights and four techniques at 640 x 360; its pixels come from closed forms (tests/python/ramps.py).
The call is Renderer.supports, which does next to nothing on the render thread, and Renderer.mask, which hands an
image over.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import penumbra_core as core
from penumbra.report import ReportWriter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import ramps


def report_s() -> float:
    """Seconds for one report, from records in memory to the last file moved into place."""
    comparison = ramps.ramp_comparison()
    scene = ramps.ramp_scene(640, 360, 2)
    comparison.scenes.append(scene)
    with tempfile.TemporaryDirectory() as folder:
        started = time.perf_counter()
        writer = ReportWriter(Path(folder) / "out")
        writer.add_scene(scene)
        writer.finish(comparison)
        return time.perf_counter() - started


def call_ms() -> tuple[float, float]:
    """Milliseconds per call of supports() and mask()."""
    scene = core.Scene()
    corners = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], np.float32)
    sheet = core.Mesh("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    scene.add_instance("sheet", sheet, np.eye(4), np.full((1, 3), 0.8, np.float32))
    light = core.Light()
    light.name, light.position_ws = "lamp", (0.0, 0.0, 4.0)
    scene.add_light(light)
    camera = core.Camera()
    placed = np.eye(4)
    placed[2, 3] = 8.0
    camera.world_from_camera, camera.width_px, camera.height_px = placed, 640, 360
    scene.camera = camera
    renderer = core.Renderer()
    renderer.set_scene(scene)
    renderer.mask(0)

    def per_call(call: object, count: int = 500) -> float:
        assert callable(call)
        started = time.perf_counter()
        for _ in range(count):
            call()
        return (time.perf_counter() - started) / count * 1e3

    return per_call(lambda: renderer.supports(0, "pcf")), per_call(lambda: renderer.mask(0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    first, *others = [report_s() for _ in range(runs)]
    print(f"report, 2 lights, 4 techniques, 640 x 360: first {first:.2f} s, then {statistics.median(others):.2f} s")
    supports, mask = call_ms()
    print(f"call into the core: supports {supports:.4f} ms, mask of 640 x 360 {mask:.4f} ms")


if __name__ == "__main__":
    main()
