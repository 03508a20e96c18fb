"""Our reference against Cycles, pixel by pixel: three scenes, every kind and shape of light.

    python tests/blender/cycles_truth.py --write docs/truth.md

The measurement is here; `test_cycles_truth.py` runs it with fewer samples and asserts.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

FloatImage = npt.NDArray[np.float64]

SIZE = (160, 120)
BATCHES = 8  # independent Cycles renders; their spread tells Cycles' noise
REFERENCE_ERROR = 0.001
CLOSE = 4.0  # standard errors


# ------------------------------------------------------------------------------------------------------------- scenes


def _cards(kit: Any) -> None:
    """Flat things: a box on the floor, a leaning card, a mirrored and sheared one in the air."""
    kit.cube("Box", half=0.5, at=(-0.9, 0.2, 0.5), turn=(0, 0, 0.5))
    kit.plane("Card", half=0.7, at=(0.8, 0.3, 0.55), turn=(1.0, 0.3, 0.2))
    kit.plane("Mirrored", half=0.4, at=(0.1, -0.7, 1.1), turn=(0.2, 0.4, 0), scale=(-1, 1.4, 1))


def _smooth(kit: Any) -> None:
    """Smooth shading: Suzanne and a coarse ball, whose normals differ from their faces'."""
    import bpy

    bpy.ops.mesh.primitive_monkey_add(location=(-0.5, 0.1, 0.75), rotation=(-0.4, 0, 0.3), size=1.5)
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_uv_sphere_add(location=(1.0, 0.0, 0.5), radius=0.5, segments=16, ring_count=8)
    bpy.ops.object.shade_smooth()


def _fence(kit: Any) -> None:
    """Thin casters: bars, and a sheet of leaves in the air that overlap."""
    for k in range(9):
        kit.cube(f"Bar {k}", half=0.5, at=(-1.2 + 0.3 * k, 0.5, 0.6), scale=(0.05, 0.05, 1.2))
    kit.cube("Rail", half=0.5, at=(0, 0.5, 0.9), scale=(2.6, 0.04, 0.08))
    for k in range(7):
        kit.plane(f"Leaf {k}", half=0.22, at=(-1.0 + 0.33 * k, -0.5, 0.9 + 0.1 * (k % 3)), turn=(0.4 * k, 0.3, k))


SCENES: dict[str, Callable[[Any], None]] = {"cards": _cards, "smooth": _smooth, "fence": _fence}


def build(kit: Any, scene: str) -> None:
    """Floor, things on it, camera; everything matt white."""
    import bpy

    kit.plane("Floor", half=6)
    SCENES[scene](kit)
    white = kit.material("White", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1), Roughness=0.0)
    for index, obj in enumerate(kit.scene.objects):
        obj.data.materials.clear()
        obj.data.materials.append(white)
        obj.pass_index = index + 1
        # Cycles moves ray origins on smooth meshes to hide the shadow terminator; that is not the truth.
        if hasattr(obj, "shadow_terminator_geometry_offset"):
            obj.shadow_terminator_geometry_offset = obj.shadow_terminator_shading_offset = 0.0
        else:  # 4.2
            obj.cycles.shadow_terminator_geometry_offset = obj.cycles.shadow_terminator_offset = 0.0
    kit.camera(at=(0.6, -5.2, 3.4), turn=(math.radians(60), 0, math.radians(6)), lens=42)
    kit.scene.render.resolution_x, kit.scene.render.resolution_y = SIZE
    bpy.context.view_layer.update()


# ------------------------------------------------------------------------------------------------------------- lights

ABOVE: dict[str, Any] = {"at": (1.6, -0.9, 3.0), "turn": (0.35, 0.42, 0.3)}
SPHERE: dict[str, Any] = {"use_soft_falloff": False}


@dataclass(frozen=True)
class Case:
    """One light."""

    name: str
    kind: str
    settings: dict[str, Any] = field(default_factory=dict)
    parent_scale: tuple[float, float, float] | None = None
    as_mesh: bool = False  # Cycles samples sheared area lights as if their sides were perpendicular

    def add(self, kit: Any) -> None:
        if self.kind == "MESH":
            self._glowing(kit)
            return
        light = kit.light(self.kind, "Light", 3.0 if self.kind == "SUN" else 60.0, **{**ABOVE, **self.settings})
        if self.parent_scale is not None:
            light.parent = kit.object("Parent", None, scale=self.parent_scale)

    @staticmethod
    def _glowing(kit: Any) -> None:
        angles = -np.arange(5) * 2 * math.pi / 5  # clockwise: its normal points down
        points = np.column_stack((0.5 * np.cos(angles), 0.35 * np.sin(angles), 0 * angles))
        panel = kit.mesh("Light", points, [range(5)], **{**ABOVE, "scale": (1.3, 1, 1)})
        panel.data.materials.append(kit.material("Glow", "ShaderNodeEmission", Strength=40.0))
        panel.visible_shadow = False


CASES = (
    Case("point, radius 0", "POINT"),
    Case("point, radius 0.3", "POINT", {**SPHERE, "shadow_soft_size": 0.3}),
    Case(
        "point, radius 0.3, object scaled (2, 3, 0.5)",
        "POINT",
        {**SPHERE, "shadow_soft_size": 0.3, "scale": (2, 3, 0.5)},
    ),
    Case("spot, radius 0", "SPOT", {"spot_size": 1.0, "spot_blend": 0.3}),
    Case(
        "spot, radius 0, object scaled (1.5, 0.8, 1.2)",
        "SPOT",
        {"spot_size": 0.9, "spot_blend": 0.5, "scale": (1.5, 0.8, 1.2)},
    ),
    Case(
        "spot, radius 0, object mirrored (-1, 1, 1)",
        "SPOT",
        {"spot_size": 0.9, "spot_blend": 0.2, "scale": (-1, 1.3, 1)},
    ),
    Case(
        "spot, radius 0.2, cone wider than the picture",
        "SPOT",
        {**SPHERE, "shadow_soft_size": 0.2, "spot_size": 3.0, "spot_blend": 0.0},
    ),
    Case("sun, angle 0", "SUN", {"angle": 0.0}),
    Case("sun, angle 0.25", "SUN", {"angle": 0.25}),
    Case("sun, angle 0.25, object scaled (3, 1, 0.2)", "SUN", {"angle": 0.25, "scale": (3, 1, 0.2)}),
    Case("square", "AREA", {"shape": "SQUARE", "size": 0.8}),
    Case("square, object scaled (2, 0.5, 7)", "AREA", {"shape": "SQUARE", "size": 0.8, "scale": (2, 0.5, 7)}),
    Case("rectangle", "AREA", {"shape": "RECTANGLE", "size": 1.4, "size_y": 0.3}),
    Case(
        "rectangle, object mirrored (-1.5, 1, 1)",
        "AREA",
        {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.4, "scale": (-1.5, 1, 1)},
    ),
    Case(
        "rectangle, object mirrored (1, 1, -1) and turned over",
        "AREA",
        {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.4, "scale": (1, 1, -1), "turn": (math.pi + 0.35, 0.42, 0.3)},
    ),
    Case(
        "rectangle, sheared by its parent; in Cycles a glowing mesh of its outline",
        "AREA",
        {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.6},
        parent_scale=(1.7, 1.0, 1.0),
        as_mesh=True,
    ),
    Case("disc", "AREA", {"shape": "DISK", "size": 0.9}),
    Case("disc, object scaled (1.6, 0.6, 1)", "AREA", {"shape": "DISK", "size": 0.9, "scale": (1.6, 0.6, 1)}),
    Case("ellipse", "AREA", {"shape": "ELLIPSE", "size": 1.3, "size_y": 0.5}),
    Case(
        "ellipse, object mirrored (1, -1.8, 1)",
        "AREA",
        {"shape": "ELLIPSE", "size": 1.0, "size_y": 0.4, "scale": (1, -1.8, 1)},
    ),
    Case("glowing pentagon (mesh)", "MESH"),
)


# -------------------------------------------------------------------------------------------------------- measurement


@dataclass(frozen=True)
class Agreement:
    """Ours against Cycles. Irradiances are in units of the largest unshadowed irradiance in the picture."""

    scene: str
    case: str
    pixels: int  # compared: both see the same object there
    left_out: int  # they see different objects (silhouettes that pass through the pixel's centre)
    terminator: int  # smooth pixels whose face's horizon cuts the light: another definition, see docs/truth.md
    bias: float  # of the mean irradiance, relative
    median: float
    p999: float
    largest: float
    noise: float  # median standard error of the difference
    at_edges: int  # pixels more than CLOSE standard errors apart, beside an edge that a pixel's centre can touch
    elsewhere: int  # the same where nothing excuses them but noise's tail
    off: npt.NDArray[np.bool_]
    ours: FloatImage
    theirs: FloatImage


def _box_mean(values: FloatImage) -> FloatImage:
    """Mean over 3 x 3 pixels."""
    padded = np.pad(values, 1, mode="edge")
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    result: FloatImage = (rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 9.0
    return result


def _outline_instead(kit: Any, light: Any) -> None:
    """Put a glowing mesh in the place of an area light, with the radiance that its watts mean."""
    import bpy

    bpy.data.objects.remove(kit.scene.objects["Light"])
    centre, u, v = (np.array(x) for x in (light.position_ws, light.half_u_ws, light.half_v_ws))
    corners = [centre + a * u + b * v for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    radiance = light.power_w[0] / (math.pi * 4.0 * float(np.linalg.norm(np.cross(u, v))))
    panel = kit.mesh("Light", corners, [(0, 1, 2, 3)])
    panel.data.materials.append(kit.material("Glow", "ShaderNodeEmission", Strength=radiance))
    panel.visible_shadow = False


def _horizon_cuts(view: Any, light: Any) -> npt.NDArray[np.bool_]:
    """Smooth-shaded pixels where the plane of the true face has the light on both sides.

    There the two define irradiance differently, see docs/truth.md.
    """
    normal = np.asarray(view.normal_ws, dtype=np.float64)
    smooth = (normal * np.asarray(view.shading_normal_ws)).sum(axis=-1) < 1.0 - 1e-6
    points = np.asarray(view.position_cr, dtype=np.float64) + np.asarray(view.eye_ws)

    def along(vector: Any) -> Any:
        return np.asarray(normal @ np.asarray(vector))

    if light.kind == "sun":
        height, reach = -along(light.direction_ws), math.sin(light.sun_angle_rad / 2.0)
    else:
        height = (normal * (np.asarray(light.position_ws) - points)).sum(axis=-1)
        if light.kind == "rectangle":
            reach = np.abs(along(light.half_u_ws)) + np.abs(along(light.half_v_ws))
        elif light.kind == "ellipse":
            reach = np.hypot(along(light.half_u_ws), along(light.half_v_ws))
        elif light.kind == "polygon":
            reach = np.max([np.abs(along(np.array(c) - light.position_ws)) for c in light.corners_ws], axis=0)
        else:
            reach = light.radius_m
    result: npt.NDArray[np.bool_] = smooth & (np.abs(height) < reach)
    return result


def _edges(view: Any, ours: FloatImage, *, hard: bool) -> npt.NDArray[np.bool_]:
    """Pixels beside another object or face, and for lights without extent beside the shadow's edge.

    Cycles' filter, a hundredth of a pixel wide, sees both sides where such an edge passes through a pixel's centre.
    """
    instance, normal = np.asarray(view.instance), np.asarray(view.normal_ws, dtype=np.float64)
    height, width = instance.shape
    edge = np.zeros((height, width), dtype=bool)
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here = (slice(0, height - dy), slice(max(0, -dx), width - max(0, dx)))
        there = (slice(dy, height), slice(max(0, dx), width - max(0, -dx)))
        change = (instance[here] != instance[there]) | (np.abs(normal[here] - normal[there]).max(axis=-1) > 1e-3)
        if hard:
            change |= np.abs(ours[here] - ours[there]) > 0.02
        edge[here] |= change
        edge[there] |= change
    return edge


def measure(kit: Any, renderer: Any, scene: str, case: Case, samples: int) -> Agreement:
    """Build the scene with one light, read it, trace it, render it with Cycles, compare."""
    import bpy
    from cycles_render import direct_diffuse
    from penumbra import scenes

    build(kit, scene)
    case.add(kit)
    bpy.context.view_layer.update()
    export = scenes.read()
    renderer.set_scene(export.scene)
    reference = renderer.reference(0, standard_error=REFERENCE_ERROR, seed=1)
    unshadowed = np.asarray(renderer.irradiance(0), dtype=np.float64)[..., 0]
    # Outside the mask the surface faces away from the light, and V is 1 there by convention, not by measurement.
    unshadowed = unshadowed * (np.asarray(reference["mask"]) > 0)
    ours = unshadowed * reference["irradiance"]
    our_error = unshadowed * reference["irradiance_standard_error"]
    view = renderer.view()

    if case.as_mesh:
        _outline_instead(kit, export.scene.lights[0])
    batches = []
    with scenes.quiet():
        for seed in range(BATCHES):
            light, index = direct_diffuse(bpy, samples=max(1, samples // BATCHES), seed=seed)
            batches.append(light[..., 0].astype(np.float64) * math.pi)
    theirs = np.mean(batches, axis=0)
    # A few renders tell little of one pixel's noise; its neighbours help.
    variance = np.var(batches, axis=0, ddof=1) / BATCHES
    their_error = np.sqrt(np.maximum(variance, _box_mean(variance)))

    seen = np.asarray(view.instance)
    same = (seen >= 0) & (index == _pass_index(kit, export, seen))
    left_out = int(((seen >= 0) | (index > 0)).sum() - same.sum())
    terminator = same & _horizon_cuts(view, export.scene.lights[0])
    same &= ~terminator
    unit = float(unshadowed[same].max())
    difference = np.abs(ours - theirs) / unit
    error = np.sqrt(our_error**2 + their_error**2) / unit + 1e-5
    values = difference[same]
    edge = _edges(view, ours / unit, hard=float(our_error.max()) == 0.0)
    off = same & (difference > CLOSE * error + 1e-4)
    return Agreement(
        scene,
        case.name,
        int(same.sum()),
        left_out,
        int(terminator.sum()),
        float(theirs[same].sum() / ours[same].sum() - 1.0),
        float(np.median(values)),
        float(np.quantile(values, 0.999)),
        float(values.max()),
        float(np.median(error[same])),
        int((off & edge).sum()),
        int((off & ~edge).sum()),
        off,
        ours / unit,
        theirs / unit,
    )


def _pass_index(kit: Any, export: Any, seen: Any) -> Any:
    """Cycles' object index for each of our instance indices; instances are sent in the depsgraph's order."""
    table = np.array([kit.scene.objects[name].pass_index for name in export.instance_names] or [0])
    return np.where(seen >= 0, table[np.maximum(seen, 0)], 0)


def measure_all(samples: int, only: Callable[[str, Case], bool] = lambda _scene, _case: True) -> Iterator[Agreement]:
    import bpy
    import penumbra_core
    from blender_kit import Kit

    renderer = penumbra_core.Renderer()
    for scene in SCENES:
        for case in CASES:
            if only(scene, case):
                bpy.ops.wm.read_factory_settings(use_empty=True)
                yield measure(Kit(), renderer, scene, case, samples)


# --------------------------------------------------------------------------------------------------------------- page


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Penumbra's reference against Cycles")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the table between its marks in this page")
    parser.add_argument("--samples", type=int, default=256, help="per pixel in Cycles, over all batches")
    parser.add_argument("--scene", choices=sorted(SCENES))
    parser.add_argument("--case", help="part of a case's name")
    parser.add_argument("--save", type=Path, metavar="DIR", help="keep both images of every case as .npz")
    options = parser.parse_args(arguments)
    sys.path[:0] = [str(Path(__file__).parent)]

    def wanted(scene: str, case: Case) -> bool:
        return options.scene in (None, scene) and (options.case is None or options.case in case.name)

    rows = []
    for row in measure_all(options.samples, wanted):
        rows.append(row)
        print(as_row(row), flush=True)
        if options.save is not None:
            options.save.mkdir(parents=True, exist_ok=True)
            name = f"{row.scene} {row.case}".replace(" ", "_").replace(",", "")
            np.savez(options.save / f"{name}.npz", ours=row.ours, theirs=row.theirs, off=row.off)
    if options.write is not None:
        write_table(options.write, rows, options.samples)
    return 0


def as_row(row: Agreement) -> str:
    cells = (
        row.scene,
        row.case,
        f"{row.pixels}",
        f"{row.left_out}",
        f"{row.terminator}",
        f"{row.bias:+.1e}",
        f"{row.median:.1e}",
        f"{row.p999:.1e}",
        f"{row.largest:.1e}",
        f"{row.noise:.1e}",
        f"{row.at_edges}",
        f"{row.elsewhere}",
    )
    return "| " + " | ".join(cells) + " |"


BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"


def write_table(page: Path, rows: list[Agreement], samples: int) -> None:
    """Put the table between the two marks of a page; the words round it are written by hand."""
    import bpy

    head = (
        "| scene | light | pixels | left out | terminator | bias | median | p99.9 | max | noise "
        "| > 4 σ at edges | > 4 σ elsewhere |\n"
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
    )
    made = (
        f"Blender {bpy.app.version_string}, {samples} samples a pixel, {SIZE[0]} x {SIZE[1]} pixels, "
        f"our reference at a standard error of {REFERENCE_ERROR:g}.\n"
    )
    text = page.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    table = "\n".join([made, head, *(as_row(row) for row in rows)])
    page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
