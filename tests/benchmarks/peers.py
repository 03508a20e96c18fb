"""Ours beside what a user would pick today: error against time of all techniques, Blender's engines, Mitsuba, Embree.

    python tests/benchmarks/peers.py --out DIR [--quick] [--scenes a,b] [--meshes DIR] [--embree PROGRAM] [--write]

Every renderer lives in a process of its own and gets the same float32 triangles, flat shaded, one light, one camera.
Each answers with the same thing, how much of the light's unshadowed irradiance arrives (V), which is held against one
truth over the same pixels. Runs are taken in turns. Every measured point is kept in DIR: a killed run goes on where it
was. `--write` puts table and curves into docs/performance.md. How each is made comparable: docs/performance-peers.md.
"""

import sys

from peers.command import main  # the folder of the same name, which Python prefers to this file

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
