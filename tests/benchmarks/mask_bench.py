"""What the penumbra mask saves: time to an error, with rays alone, rays under the mask, and light samples.

    python tests/benchmarks/mask_bench.py [--meshes DIR] [--size WxH] [--scenes a,b] [--techniques a,b] ...

For each scene and light: every technique over its quality setting, errors against one reference, dynamic frames timed
in turns in one run; the time at which the RMSE over the penumbra is 0.005, interpolated in logarithms; its ratio to
that of `ray_traced`. Beside it what the mask holds, and how many pixels it is wrongly sure of. Markdown on standard
output.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import penumbra_core as core
from penumbra import scenes

ROOT = Path(__file__).resolve().parents[2]
TARGET = 0.005
SWEEPS: dict[str, tuple[str, tuple[int, ...]]] = {
    "ray_traced": ("rays", (16, 64, 256, 1024)),
    "masked_rays": ("rays", (16, 64, 256, 1024)),
    "light_samples": ("samples", (16, 64, 256)),
}
EXAMPLES = ("courtyard", "desk", "plaza")
MESHES = ("stanford-bunny",)


def time_to(target: float, errors: list[float], times: list[float]) -> float:
    """Interpolated in logarithms between the steps around it, or along the nearest two; inf if errors never fall."""
    steps = sorted(zip(errors, times, strict=True), reverse=True)
    for i in range(len(steps) - 1):
        (e0, t0), (e1, t1) = steps[i], steps[i + 1]
        if e0 > e1 and (e1 <= target or i == len(steps) - 2):
            at = (math.log(e0) - math.log(target)) / (math.log(e0) - math.log(e1))
            return math.exp(math.log(t0) + at * (math.log(t1) - math.log(t0)))
    return math.inf


def mask_of(renderer: Any, light: int) -> tuple[Any, Any, Any] | None:
    """Surely lit, surely in umbra, maybe."""
    plan = renderer.visibility(light, "masked_rays")["plan"]
    if not any(step["step"] == "penumbra mask" and step["state"] == "run" for step in plan):
        return None
    rgb = renderer.debug_images(light, "masked_rays", {}, ["mask"])[0]["rgb"]
    return rgb.min(-1) > 0.99, rgb.max(-1) < 0.01, (rgb[..., 0] > 0.9) & (rgb[..., 2] < 0.2)


def measure(name: str, path: Path, arguments: argparse.Namespace) -> None:
    scenes.open_scene(path)
    export = scenes.read(size=arguments.size)
    renderer = core.Renderer()
    renderer.set_scene(export.scene)
    for index, light in enumerate(export.scene.lights):
        exact = arguments.exact and light.kind in ("rectangle", "polygon")
        truth = renderer.reference(index, standard_error=arguments.reference_error, exact=exact)
        asked, area = np.asarray(truth["mask"]) > 0, np.asarray(truth["area"])
        penumbra = asked & (area > 1e-4) & (area < 1 - 1e-4)
        title = f"{name}, {light.name} ({light.kind})"
        found = mask_of(renderer, index)
        if found is None or not penumbra.any():
            print(f"\n{title}: no mask, or no penumbra")
            continue
        lit, umbra, maybe = (part & asked for part in found)
        wrong = (lit & (area < 1 - 1e-4)) | (umbra & (area > 1e-4))
        print(
            f"\n**{title}**: penumbra {100 * penumbra.sum() / asked.sum():.1f} % of {asked.sum()} pixels; mask: lit "
            f"{100 * lit.sum() / asked.sum():.1f} %, umbra {100 * umbra.sum() / asked.sum():.1f} %, maybe "
            f"{100 * maybe.sum() / asked.sum():.1f} %; wrongly sure {wrong.sum()} pixels, "
            f"{100 * wrong.sum() / penumbra.sum():.4f} % of the penumbra\n"
        )
        print("| technique | setting | penumbra RMSE | ms | to 0.005: ms | of ray_traced |\n|---|---|---|---|---|---|")
        jobs = [(t, {SWEEPS[t][0]: v}) for t in arguments.techniques for v in SWEEPS[t][1]]
        measured = renderer.measure(
            index, jobs, max_seconds=arguments.seconds, min_runs=arguments.runs, max_runs=max(20, arguments.runs)
        )
        times: dict[str, list[float]] = {}
        errors: dict[str, list[float]] = {}
        for (technique, settings), result in zip(jobs, measured, strict=True):
            image = renderer.visibility(index, technique, settings)["visibility"]
            error = core.measure_errors([image], area, truth["standard_error"], truth["mask"])["penumbra_rmse"]
            times.setdefault(technique, []).append(result["dynamic"]["median"])
            errors.setdefault(technique, []).append(error)
        base = time_to(TARGET, errors["ray_traced"], times["ray_traced"])
        for technique in arguments.techniques:
            reach = time_to(TARGET, errors[technique], times[technique])
            for i, value in enumerate(SWEEPS[technique][1]):
                last = f"{reach:.0f} | {reach / base:.2f}" if i == 0 else " | "
                print(f"| {technique} | {value} | {errors[technique][i]:.4f} | {times[technique][i]:.1f} | {last} |")
        sys.stdout.flush()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", type=Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--size", default="640x360", type=lambda text: tuple(map(int, text.split("x"))))
    parser.add_argument("--scenes", default=",".join(EXAMPLES + MESHES))
    parser.add_argument("--techniques", default=",".join(SWEEPS), type=lambda text: text.split(","))
    parser.add_argument("--reference-error", type=float, default=0.002)
    parser.add_argument("--exact", action="store_true", help="the exact reference for polygonal lights (slow)")
    parser.add_argument("--seconds", type=float, default=3.0, help="per job, at most")
    parser.add_argument("--runs", type=int, default=3, help="per job, at least")
    arguments = parser.parse_args()
    for name in arguments.scenes.split(","):
        path = ROOT / "examples" / f"{name}.blend" if name in EXAMPLES else arguments.meshes / f"{name}.obj"
        if not path.is_file():
            print(f"{path.name} is not there and left out", file=sys.stderr)
            continue
        measure(name, path, arguments)
    return 0


if __name__ == "__main__":
    sys.exit(main())
