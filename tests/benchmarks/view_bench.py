"""What a view costs, drawn and by rays, and on how many pixels the two differ.

    python tests/benchmarks/view_bench.py [--meshes DIR] [--seconds S]

The scenes are those of peers.py: a torus knot, the examples, the meshes of a folder over a floor. Prints a table in
Markdown: milliseconds by the wall clock, the median of views rendered in turns with frames of one ray a pixel, as
`penumbra compare` measures them; and the pixels whose triangle is another one, of those that show anything.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import penumbra_core as core
from peers.ours import core_scene
from peers.sources import make, names

SIZE_PX = (512, 512)
JOB = [("ray_traced", {"rays": 1})]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meshes", type=Path, help="folder of .obj, .ply and .stl files")
    parser.add_argument("--seconds", type=float, default=3.0, help="of each measuring")
    arguments = parser.parse_args()
    renderers = [core.Renderer(view_by=by) for by in ("raster", "rays")]
    print(f"{renderers[0].environment['gl_renderer']}, {renderers[0].environment['threads']} threads, {SIZE_PX}\n")
    print("| scene | triangles | drawn | by rays | by rays / drawn | other triangle |\n|---|---:|---:|---:|---:|---:|")
    for name, file in names(arguments.meshes).items():
        shared = make(name, file, SIZE_PX)
        times, seen = [], []
        for renderer in renderers:
            renderer.set_scene(core_scene(core, shared))
            view = renderer.view()
            seen.append(np.stack([np.asarray(view.instance), np.asarray(view.triangle)]))
            (measured,) = renderer.measure(0, JOB, max_seconds=arguments.seconds, min_runs=20, max_runs=200)
            times.append(measured["view"]["median"])
        other = np.any(seen[0] != seen[1], axis=0).sum()
        print(
            f"| {name} | {shared.triangle_count} | {times[0]:.1f} | {times[1]:.1f} | {times[1] / times[0]:.2f} | "
            f"{other} of {(seen[0][0] >= 0).sum()} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
