"""Seeds for the fuzzer of the scene border: a floor and a closed box under each kind of light, and the same with the
numbers that mean trouble. Bytes as scene_bytes.h reads them."""

from __future__ import annotations

import itertools
import math
import struct
from pathlib import Path

HERE = Path(__file__).parent / "corpus"
KINDS = ("point", "spot", "sun", "rectangle", "ellipse", "line", "polygon")


def number(value: float) -> bytes:
    if -8 <= value < 8 and value == round(4 * value) / 4:
        return bytes([32 + round(4 * value)])
    return b"\xf0" + struct.pack("<d", value)


def vector(*values: float) -> bytes:
    return b"".join(map(number, values))


def mesh(positions: list[tuple[float, ...]], triangles: list[tuple[int, ...]]) -> bytes:
    places = b"".join(vector(*position) for position in positions)
    corners = bytes(itertools.chain.from_iterable(triangles))
    return bytes([len(positions)]) + places + bytes([len(triangles)]) + corners + bytes(2)


SHEET = mesh([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2), (0, 2, 3)])
BOX = mesh(
    [(x, y, z) for z in (1, 2) for y in (-1, 1) for x in (-1, 1)],
    [t for a, b, c, d in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
     for t in ((a, b, c), (a, c, d))],
)  # fmt: skip
EMPTY = mesh([], [])


def light(kind: str, at: tuple[float, ...] = (0.25, 0.5, 4.0), size: float = 0.5) -> bytes:
    v = 0.0 if kind == "line" else size
    made = bytes([KINDS.index(kind)]) + vector(*at) + vector(0, 0, -1) + vector(size, 0, 0) + vector(0, v, 0)
    if kind == "polygon":
        made += bytes([3]) + vector(-1, -1) + vector(1, -1) + vector(0, 1)
    return made + number(size) + vector(0.25, 2, 1) + vector(1, 1) + vector(7, 7, 7) + bytes(1)


def scene(meshes: bytes, lights: list[bytes], *, wild: bool = False, at: float = 0.0) -> bytes:
    instances = b"".join(bytes([i, 0]) + vector(0, 0, at) + vector(0.75, 0.75, 0.75) + bytes(3) for i in (0, 1))
    camera = bytes(1) + vector(0, 0, 7.75) + bytes(1) + vector(0.5, 3, 0, 0, 1, 0.25) + number(0)
    size = struct.pack("<IB", 64, 48) if wild else bytes([64, 48])
    head = bytes([int(wild), 0]) + meshes + bytes([2])
    return head + instances + bytes([len(lights)]) + b"".join(lights) + camera + size


def main() -> None:
    HERE.mkdir(exist_ok=True)
    for kind in KINDS:
        (HERE / f"{kind}").write_bytes(scene(SHEET + BOX, [light(kind)]))
        (HERE / f"{kind}-touching").write_bytes(scene(SHEET + BOX, [light(kind, (1, 1, 2), 1.0)]))
        (HERE / f"{kind}-far").write_bytes(scene(SHEET + BOX, [light(kind, (1e7, 0, 1e7), 1e6)], wild=True, at=1e17))
    for name, value in {"nan": math.nan, "infinite": math.inf, "tiny": 1e-300, "huge": 1e18, "half": 1e-45}.items():
        (HERE / name).write_bytes(scene(SHEET + BOX, [light("rectangle", (value, 0, 4))], wild=True))
        (HERE / f"{name}-size").write_bytes(scene(SHEET + BOX, [light("ellipse", size=value)], wild=True))
        (HERE / f"{name}-place").write_bytes(scene(SHEET + BOX, [light("point")], wild=True, at=value))
    (HERE / "empty").write_bytes(scene(EMPTY + EMPTY, []))
    (HERE / "two-lights").write_bytes(scene(BOX + BOX, [light("point"), light("sun")]))


if __name__ == "__main__":
    main()
