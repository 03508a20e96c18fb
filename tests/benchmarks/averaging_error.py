"""Plateaus against Heckbert and Herf's averages of 16 and 256 hard shadows; the picture and the table of
docs/techniques/plateaus.md, after figures 5 and 6 of [Haines2001].

    python tests/benchmarks/averaging_error.py [--size WxH] [--samples 16 256] [--picture FILE]

A disc light over one plane, casters standing on it and in the air. On a plane the matrix method of [HeckbertHerf1997]
and the average of as many hard shadow maps are the same picture: each sample point of the light throws one hard
shadow, and the mean of all is kept. `light_samples` is that average.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import penumbra_core as core
from penumbra import scenes
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
PLATEAUS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("plateaus, linear", {}),
    ("plateaus, sine", {"falloff": "sine"}),
    ("plateaus, r = 0.1 h, sine", {"light_shape": "disc", "radius_model": "linear", "k": 0.1, "falloff": "sine"}),
    ("plateaus, both sides (ours)", {"sides": "both"}),
)
Image3 = npt.NDArray[np.uint8]


def furnish() -> None:
    """A slab that stands, a ring that leans, a cube, and a board in the air, under a disc of radius 0.5 five up."""
    import bpy
    from mathutils import Euler, Vector

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=40.0)
    bpy.context.object.name = "Ground"
    for place, turn, scale in (
        ((-1.1, 0.3, 0.9), (0.0, 0.0, 0.5), (0.8, 0.12, 0.9)),
        ((0.1, -0.8, 0.3), (0.0, 0.0, 0.9), (0.3, 0.3, 0.3)),
        ((1.3, -0.9, 1.6), (0.0, 0.0, -0.3), (0.6, 0.3, 0.03)),
    ):
        bpy.ops.mesh.primitive_cube_add(size=2.0, location=place, rotation=turn)
        bpy.context.object.scale = scale
    bpy.ops.mesh.primitive_torus_add(
        location=(1.0, 0.7, 0.75), rotation=(1.35, 0.0, 0.6), major_radius=0.6, minor_radius=0.15, major_segments=64
    )
    light = bpy.data.objects.new("Disc", bpy.data.lights.new("Disc", "AREA"))
    light.data.shape, light.data.size = "DISK", 1.0
    light.location = (-0.4, -0.6, 5.0)
    bpy.context.collection.objects.link(light)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0.5, -5.6, 6.6)
    camera.rotation_euler = (Vector((0.2, 0.1, 0.1)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    assert isinstance(camera.rotation_euler, Euler)
    camera.data.lens = 44.0
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def shaded(v: npt.NDArray[np.float32], albedo: npt.NDArray[np.float32], plane: npt.NDArray[np.bool_]) -> Image3:
    """V as grey on the plane, the casters flat and darker; display values."""
    grey = np.where(plane, 0.12 + 0.83 * v, 0.25 + 0.25 * albedo)
    return np.repeat((np.clip(grey, 0, 1) * 255).astype(np.uint8)[..., None], 3, axis=2)


def signed(difference: npt.NDArray[np.float32], plane: npt.NDArray[np.bool_]) -> Image3:
    """Red: plateaus darker; blue: lighter; full colour at 1."""
    strength = np.clip(np.abs(difference), 0, 1)[..., None]
    colour = np.where((difference < 0)[..., None], [0.75, 0.05, 0.05], [0.05, 0.2, 0.8])
    rgb = np.where(plane[..., None], 1.0 - strength * (1.0 - colour), 0.6)
    return (rgb * 255).astype(np.uint8)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", default="640x400", type=lambda text: tuple(map(int, text.split("x"))))
    parser.add_argument("--samples", type=int, nargs="+", default=[16, 256])
    parser.add_argument("--map-size", type=int, default=2048)
    parser.add_argument("--picture", type=Path, default=ROOT / "docs" / "images" / "plateaus_averages.png")
    arguments = parser.parse_args()
    with scenes.quiet():
        furnish()
    export = scenes.read(size=arguments.size)
    renderer = core.Renderer()
    renderer.set_scene(export.scene)
    view = renderer.view()
    height_m = np.asarray(view.position_cr)[..., 2] + view.eye_ws[2]
    plane = (np.asarray(view.normal_ws)[..., 2] > 0.999) & (np.abs(height_m) < 1e-4)
    truth = renderer.reference(0, standard_error=0.002)
    mask = (np.asarray(truth["mask"]) > 0) & plane

    pictures: dict[str, npt.NDArray[np.float32]] = {}
    times: dict[str, float] = {}

    def draw(title: str, technique: str, settings: dict[str, Any]) -> None:
        timed = renderer.measure(0, [(technique, settings)], min_runs=3, max_runs=5, max_seconds=4.0)[0]
        pictures[title] = np.asarray(renderer.visibility(0, technique, settings)["visibility"])
        times[title] = float(timed["dynamic"]["median"])
        print(f"{title}: done", file=sys.stderr, flush=True)

    for samples in arguments.samples:
        more = {"samples": samples, "map_size": arguments.map_size, "pattern": "jittered"}
        draw(f"average of {samples}", "light_samples", more)
    draw("hard shadow", "shadow_map", {"map_size": arguments.map_size})
    for title, settings in PLATEAUS:
        draw(title, "plateaus", settings)

    best = f"average of {max(arguments.samples)}"
    print(f"| on the plane | penumbra RMSE | bias | from the {best}: mean | RMS | least, most | frame over hard |")
    print("|---|---|---|---|---|---|---|")
    for title, image in pictures.items():
        errors = core.measure_errors([image], truth["area"], truth["standard_error"], mask.astype(np.uint8))
        difference = (image - pictures[best])[mask]
        print(
            f"| {title} | {errors['penumbra_rmse']:.3f} | {errors['bias']:+.4f} | {difference.mean():+.4f} "
            f"| {np.sqrt((difference**2).mean()):.3f} | {difference.min():+.2f}, {difference.max():+.2f} "
            f"| {times[title] / times['hard shadow']:.1f} |"
        )

    albedo = np.asarray(view.normal_ws)[..., 2].astype(np.float32)
    sine = pictures["plateaus, sine"]
    panels = [
        shaded(sine, albedo, plane),
        shaded(pictures[best], albedo, plane),
        signed(sine - pictures[best], plane),
    ]
    whole = np.concatenate([panel[::-1] for panel in panels], axis=1)
    Image.fromarray(whole).save(arguments.picture, optimize=True)
    print(arguments.picture, file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
