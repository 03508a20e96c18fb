"""Hypothesis strategies: scenes as plain data, so that a failure shrinks to the few numbers that matter.

Profiles: `ci` (always the same examples, no clock) unless PENUMBRA_PROPERTIES names another: `deep` draws new examples
at every run, and many of them.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

_COMMON: dict[str, Any] = {
    "deadline": None,  # compiling a shader takes as long as a hundred examples
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.function_scoped_fixture],
}
settings.register_profile("ci", derandomize=True, database=None, max_examples=5, **_COMMON)
settings.register_profile("deep", max_examples=3000, print_blob=True, **_COMMON)
settings.load_profile(os.environ.get("PENUMBRA_PROPERTIES", "ci"))
many = settings(max_examples=8 * settings().max_examples)
"""For what renders nothing."""

T = TypeVar("T")

Vector = tuple[float, float, float]
Matrix = tuple[tuple[float, ...], ...]

KINDS = ("point", "spot", "sun", "rectangle", "ellipse", "line", "polygon")


@dataclass(frozen=True)
class MeshSpec:
    positions: tuple[Vector, ...]
    triangles: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True)
class InstanceSpec:
    mesh: MeshSpec
    matrix: Matrix
    casts: bool = True
    receives: bool = True
    visible: bool = True


@dataclass(frozen=True)
class LightSpec:
    kind: str
    members: dict[str, Any] = field(default_factory=dict)
    """What differs from a light's defaults; lengths in metres."""


@dataclass(frozen=True)
class CameraSpec:
    matrix: Matrix
    members: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SceneSpec:
    instances: tuple[InstanceSpec, ...]
    light: LightSpec
    camera: CameraSpec

    def build(
        self,
        core: Any,
        *,
        scale: float = 1.0,
        offset: Vector = (0.0, 0.0, 0.0),
        order: list[int] | None = None,
        made: dict[MeshSpec, Any] | None = None,
    ) -> Any:
        """A core.Scene of it, scaled about the origin and then moved; `order` seeds each mesh's order of triangles.

        made: meshes of former scenes, to be shared with them
        """
        scene = core.Scene()
        made = made if made is not None else {}
        for number, instance in enumerate(self.instances):
            if instance.mesh not in made:
                made[instance.mesh] = _mesh(core, instance.mesh, order)
            scene.add_instance(
                f"instance {number}", made[instance.mesh], _moved(instance.matrix, scale, offset),
                np.full((1, 3), 0.8, np.float32), instance.casts, instance.receives, instance.visible,
            )  # fmt: skip
        scene.add_light(_light(core, self.light, scale, offset))
        camera = scene.camera
        camera.world_from_camera = _moved(self.camera.matrix, scale, offset)
        for name, value in self.camera.members.items():
            setattr(camera, name, value * scale if name.endswith("_m") else value)
        return scene


def _mesh(core: Any, spec: MeshSpec, order: list[int] | None) -> Any:
    triangles = np.array(spec.triangles, np.uint32).reshape(-1, 3)
    if order is not None:
        triangles = triangles[np.argsort([order[i % len(order)] for i in range(len(triangles))], kind="stable")]
    return core.Mesh("mesh", np.array(spec.positions, np.float32).reshape(-1, 3), triangles)


def _moved(matrix: Matrix, scale: float, offset: Vector) -> npt.NDArray[np.float64]:
    moved = np.array(matrix, np.float64)
    moved[:3] *= scale
    moved[:3, 3] += offset
    return moved


_POINTS = ("position_ws", "corners_ws")
_LENGTHS = ("half_u_ws", "half_v_ws", "radius_m")


def _light(core: Any, spec: LightSpec, scale: float, offset: Vector) -> Any:
    light = core.Light()
    light.name, light.kind = "light", spec.kind
    for name, value in spec.members.items():
        if name in _POINTS:
            value = (np.array(value, np.float64) * scale + offset).tolist()
        elif name == "radius_m" or (name in _LENGTHS and spec.kind != "spot"):
            value = (np.array(value, np.float64) * scale).tolist()
        setattr(light, name, value)
    return light


# --- numbers ---------------------------------------------------------------------------------------------------------


def grid(low: int, high: int, parts: int = 4) -> st.SearchStrategy[float]:
    """Multiples of 1 / parts: points coincide and faces touch far more often than with any numbers."""
    return st.integers(low * parts, high * parts).map(lambda whole: whole / parts)


def coordinates(reach: int, exact: bool = False) -> st.SearchStrategy[float]:
    return grid(-reach, reach) | (st.nothing() if exact else st.floats(-reach, reach, width=32, allow_subnormal=False))


def mostly(often: st.SearchStrategy[T], seldom: st.SearchStrategy[T]) -> st.SearchStrategy[T]:
    """Four times in five from `often`: what is nearly always drawn keeps the rest from meaning anything."""
    return st.integers(0, 4).flatmap(lambda number: seldom if number == 4 else often)


def vectors(numbers: st.SearchStrategy[float]) -> st.SearchStrategy[Vector]:
    return st.tuples(numbers, numbers, numbers)


def sizes(exact: bool) -> st.SearchStrategy[float]:
    """Of lights, in metres; scenes are about four metres large."""
    return mostly(
        st.sampled_from([0.5, 0.125, 1.0]),
        st.sampled_from([0.0, 4.0, 32.0] if exact else [0.0, 1e-9, 1e-3, 3.0, 30.0]),
    )


# --- geometry --------------------------------------------------------------------------------------------------------


def _box(half: Vector) -> MeshSpec:
    x, y, z = half
    corners = tuple((sx * x, sy * y, sz * z) for sz in (-1, 1) for sy in (-1, 1) for sx in (-1, 1))
    quads = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    return MeshSpec(corners, tuple(t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))))


def sheet(half: float) -> MeshSpec:
    """A square in the plane z = 0, facing up."""
    return MeshSpec(((-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)),
                    ((0, 1, 2), (0, 2, 3)))  # fmt: skip


@st.composite
def soups(draw: st.DrawFn, exact: bool) -> MeshSpec:
    """Any topology: open, non-manifold, turned over, without area, doubled, empty."""
    positions = draw(st.lists(vectors(coordinates(2, exact)), min_size=0, max_size=12))
    if not positions:
        return MeshSpec((), ())
    corner = st.integers(0, len(positions) - 1)
    return MeshSpec(tuple(positions), tuple(draw(st.lists(st.tuples(corner, corner, corner), max_size=20))))


def meshes(exact: bool) -> st.SearchStrategy[MeshSpec]:
    halves = [0.0, 0.125, 0.5, 1.0] if exact else [0.0, 1e-6, 0.1, 0.5, 1.0]
    return st.one_of(
        st.builds(_box, vectors(st.sampled_from(halves))),
        st.builds(sheet, st.sampled_from([0.25, 1.0, 2.0])),
        soups(exact),
    )


IDENTITY: Matrix = tuple(tuple(float(i == j) for j in range(4)) for i in range(4))


def _affine(linear: npt.NDArray[np.float64], at: Vector) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = at
    return tuple(tuple(float(value) for value in row) for row in matrix)


def _turn(axis: int, angle_rad: float) -> npt.NDArray[np.float64]:
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[i, i] = turn[j, j] = math.cos(angle_rad)
    turn[j, i], turn[i, j] = math.sin(angle_rad), -math.sin(angle_rad)
    return turn


def turns(angles_rad: list[float]) -> st.SearchStrategy[npt.NDArray[np.float64]]:
    """About an axis by one of the angles; quarters of a turn without rounding."""
    turn = st.builds(_turn, st.integers(0, 2), st.sampled_from(angles_rad))
    return turn.map(lambda found: np.where(np.abs(found - np.round(found)) < 1e-12, np.round(found), found))


QUARTERS = [0.0, math.pi / 2, math.pi]
any_turn = turns(QUARTERS) | st.builds(_turn, st.integers(0, 2), st.floats(-3.2, 3.2))


@st.composite
def matrices(draw: st.DrawFn, exact: bool) -> Matrix:
    """Turned, scaled, mirrored, sheared; now and then singular."""
    stretch = mostly(st.sampled_from([1.0, 0.5, 2.0, -1.0]), st.sampled_from([-4.0] if exact else [1e-3, 1e-6, -3.0]))
    linear = draw(turns(QUARTERS) if exact else any_turn) @ np.diag(draw(vectors(stretch)))
    if draw(st.integers(0, 49)) == 49:
        linear[:, 0] = linear[:, 1] * draw(st.sampled_from([0.0, 1.0]))
    if draw(st.booleans()):
        shear = np.eye(3)
        shear[0, 1], shear[0, 2] = draw(grid(-2, 2)), draw(grid(-2, 2))
        linear = shear @ linear
    x, y = (draw(mostly(coordinates(1, exact), coordinates(4, exact))) for _ in range(2))
    return _affine(linear, (x, y, draw(mostly(grid(0, 3), coordinates(3, exact)))))


@st.composite
def instances(draw: st.DrawFn, exact: bool) -> InstanceSpec:
    nearly_always = st.integers(0, 7).map(lambda number: number != 7)
    return InstanceSpec(
        draw(meshes(exact)), draw(matrices(exact)), draw(nearly_always), draw(nearly_always), draw(nearly_always)
    )


# --- lights and cameras ----------------------------------------------------------------------------------------------

directions = vectors(grid(-1, 1)).filter(any)


@st.composite
def lights(draw: st.DrawFn, kind: str, exact: bool) -> LightSpec:
    """Above, inside, on and under what there is; from no size to ten times the scene."""
    x, y = (draw(mostly(coordinates(2, exact), coordinates(9, exact))) for _ in range(2))
    at: Vector = (x, y, draw(mostly(grid(2, 6), grid(-1, 2) | coordinates(30, exact))))
    if kind in ("point", "spot"):
        members: dict[str, Any] = {"position_ws": at, "radius_m": draw(sizes(exact))}
        if kind == "spot":
            members |= {
                "direction_ws": draw(mostly(st.just((0.0, 0.0, -1.0)), directions)),
                "half_u_ws": draw(st.just((1.0, 0.0, 0.0)) | directions),
                "spot_angle_rad": draw(st.sampled_from([1.2, 0.0, 0.01, 2.5, math.pi])),
                "spot_blend": draw(st.sampled_from([0.15, 0.0, 1.0])),
                "spot_stretch": draw(st.sampled_from([(1.0, 1.0), (0.2, 1.0), (3.0, 1e-3)])),
            }
        return LightSpec(kind, members)
    if kind == "sun":
        towards = draw(mostly(st.just((0.2, 0.1, -1.0)), directions))
        angle = draw(st.sampled_from([0.1, 0.0, 1e-6, 0.0093, 1.0, math.pi]))
        return LightSpec(kind, {"direction_ws": towards, "sun_angle_rad": angle})
    u, v = draw(sizes(exact)), draw(sizes(exact))
    turn = draw(turns([0.0, math.pi / 2]) if exact else mostly(turns([0.0, 0.3, -0.4]), any_turn))
    half_u, half_v = (turn @ (u, 0.0, 0.0)).tolist(), (turn @ (0.0, v, 0.0)).tolist()
    members = {"position_ws": at, "direction_ws": (turn @ (0.0, 0.0, -1.0)).tolist()}
    if kind == "polygon":
        first = 0.0 if exact else draw(st.floats(0.0, 1.0))
        count = 4 if exact else draw(st.integers(3, 8))
        around = [2.0 * math.pi * (i + first) / count for i in range(count)]
        plane = np.array([(max(u, 1e-3) * math.cos(a), max(v, 1e-3) * math.sin(a), 0.0) for a in around])
        corners = (np.round(plane * 64.0) / 64.0 if exact else plane) @ turn.T + at
        return LightSpec(kind, members | {"corners_ws": corners.tolist()})
    members["half_u_ws"] = half_u
    if kind != "line":
        members["half_v_ws"] = half_v if draw(st.booleans()) else (turn @ (0.5 * u, v, 0.0)).tolist()
    return LightSpec(kind, members)


def looking(eye: Vector, at: Vector, roll_rad: float = 0.0) -> Matrix:
    """World from a camera at `eye` that looks at `at`; the two differ."""
    backward = np.subtract(eye, at)
    backward /= np.linalg.norm(backward)
    up = (0.0, 1.0, 0.0) if abs(backward[2]) > 0.99 else (0.0, 0.0, 1.0)
    right = np.cross(up, backward)
    right /= np.linalg.norm(right)
    return _affine(np.stack([right, np.cross(backward, right), backward], 1) @ _turn(2, roll_rad), eye)


@st.composite
def cameras(draw: st.DrawFn) -> CameraSpec:
    outside = st.sampled_from([(0.0, 0.0, 9.0), (0.0, -7.0, 5.0), (4.0, 4.0, 8.0)])
    eye = draw(mostly(outside, st.sampled_from([(5.0, 4.0, 0.5), (0.5, 0.25, 1.0), (1.0, 2.0, -3.0)])))
    members: dict[str, Any] = {"near_m": draw(st.sampled_from([0.1, 1e-3])), "far_m": 100.0}
    members["width_px"], members["height_px"] = draw(
        mostly(st.just((24, 18)), st.sampled_from([(16, 16), (1, 1), (33, 7)]))
    )
    if draw(st.booleans()):
        members |= {"orthographic": True, "half_width_m": draw(mostly(st.just(3.0), st.sampled_from([0.1, 20.0])))}
    else:
        members["tan_half_width"] = draw(mostly(st.sampled_from([0.6, 0.3]), st.sampled_from([0.01, 20.0])))
    if draw(st.booleans()):
        members |= {"shift": draw(st.sampled_from([(0.0, 0.0), (0.3, -0.2)])),
                    "pixel_offset": draw(st.sampled_from([(0.0, 0.0), (0.25, -0.4)])),
                    "pixel_aspect": draw(st.sampled_from([1.0, 0.5, 3.0]))}  # fmt: skip
    return CameraSpec(looking(eye, (0.0, 0.0, 0.25), draw(st.sampled_from([0.0, 0.4, math.pi]))), members)


@st.composite
def scenes(draw: st.DrawFn, exact: bool = False) -> SceneSpec:
    """Most have a floor, so that something is shaded; all have one light.

    exact: of such numbers that a move by a multiple of 1/4 rounds nowhere
    """
    parts = draw(st.lists(instances(exact), min_size=draw(st.integers(0, 3)), max_size=4))
    if draw(st.integers(0, 9)) < 9:
        parts.insert(0, InstanceSpec(sheet(4.0), IDENTITY))
    light = draw(lights(draw(st.sampled_from(KINDS)), exact))
    return SceneSpec(tuple(parts), light, draw(cameras()))


def changed(scene: SceneSpec, other: SceneSpec, what: str) -> SceneSpec:
    """The scene with one part of another: what an artist changes between two frames."""
    if what == "camera":
        return replace(scene, camera=other.camera)
    if what == "light":
        return replace(scene, light=other.light)
    if what == "meshes":
        return replace(scene, instances=other.instances)
    pairs = zip(scene.instances, other.instances, strict=False)
    moved = tuple(replace(mine, matrix=its.matrix) for mine, its in pairs)
    return replace(scene, instances=moved + scene.instances[len(moved) :])


# --- settings --------------------------------------------------------------------------------------------------------

_DEAREST = {"map_size": 128, "size": 128, "mask_size": 128, "samples": 24, "rays": 64, "first_rays": 64,
            "check_rays": 32, "early_out_rays": 64, "max_samples": 9, "kernel": 31}  # fmt: skip
"""Above these a setting only costs more: the code is the same."""


def values_of(setting: dict[str, Any]) -> st.SearchStrategy[Any]:
    """Any value that the setting's description allows, the dearest left out."""
    low, high = setting["minimum"], setting["maximum"]
    if setting["type"] == "bool":
        return st.booleans()
    if setting["type"] == "choice":
        return (
            st.sampled_from(setting["choices"]) if setting["choices"] else st.sampled_from(["auto", "instance 0", "é"])
        )
    if setting["type"] == "int":
        return st.integers(int(low), min(int(high), _DEAREST.get(setting["id"], int(high))))
    return st.sampled_from([float(low), float(high)]) | st.floats(low, high, allow_subnormal=False)


def cheap(technique: dict[str, Any]) -> dict[str, Any]:
    """The technique's own settings but for small maps and few samples."""
    small = {"map_size": 64, "size": 64, "mask_size": 64, "samples": 4, "rays": 8, "first_rays": 8}
    return {setting["id"]: small[setting["id"]] for setting in technique["settings"] if setting["id"] in small}


def settings_of(technique: dict[str, Any], fixed: frozenset[str] = frozenset()) -> st.SearchStrategy[dict[str, Any]]:
    optional = {setting["id"]: values_of(setting) for setting in technique["settings"] if setting["id"] not in fixed}
    return st.fixed_dictionaries({}, optional=optional).map(lambda given: cheap(technique) | given)
