"""The cases: one table, each a row of scenes, what must hold on them, and from which figure on it does."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from . import scenes, shapes
from .properties import VISIBLE_STEP
from .setups import Lamp, Part, Setup, carried, odd_turn, reordered, under

Build = Callable[[], Sequence[Setup]]


@dataclass(frozen=True)
class Check:
    property: str  # key of run.MEASURES
    bound: float  # up to here it holds


@dataclass(frozen=True)
class Case:
    id: str
    what: str  # of the scene, one sentence
    build: Build | None = None  # the frames; None: the border of the core, which has no picture
    checks: tuple[Check, ...] = ()  # beside those of EVERY_PICTURE
    truth: str = "exact"  # "exact" for rectangles and polygons, or "rays"
    sweep: str = ""  # what is swept in place of scenes: "samples" or "maps"
    ends_s: float = 60.0
    memory_mb: float = 1024.0  # at once, beyond what the process had in use before: the driver keeps its programs


EVERY_PICTURE = (Check("finite", 0.0), Check("in 0 to 1", 0.0))
"""And that it ends in the case's time and memory."""

# A comparison flips where an edge falls within rounding of a pixel: 4 pixels in 1000 are allowed in the tests of the
# core as well (every_technique_gl_test.cpp), which is an RMS of 0.06 if all of them flip from 0 to 1.
SAME = Check("same image", 0.06)
SAME_MASK = Check("same mask", 0.005)
# What a picture with 8 bits shows of a wrong penumbra; methods that draw no true penumbra have their own bounds.
PENUMBRA = Check("penumbra", 0.1)
ELSEWHERE = Check("umbra and light", 0.002)
MONOTONE = Check("monotone", 0.5 * VISIBLE_STEP)
STEADY = (Check("no popping", 0.0), Check("even steps", 3.0))


def _scaled(power: int) -> Case:
    return Case(
        f"scale-1e{power}",
        f"the yard, 10^{power} times as large",
        lambda: (scenes.yard(), carried(scenes.yard(), 10.0**power)),
        (SAME, SAME_MASK),
    )


def _moved(power: int) -> Case:
    far = 10.0**power
    return Case(
        f"moved-1e{power}",
        f"the yard, moved by 10^{power} m along all axes",
        lambda: (scenes.yard(), carried(scenes.yard(), by=(far, -far, far))),
        (SAME, SAME_MASK),
    )


def _light_size(kind: str, size: float) -> Case:
    label = f"{size:g}".replace("e-0", "e-")
    exact = kind in ("rectangle", "polygon") and size > 0.0
    # A sphere grows upwards, so that the scene stays outside of it.
    height = scenes.LIGHT_HEIGHT_M + (0.5 * size if kind in ("point", "spot") else 0.0)
    return Case(
        f"light-{kind}-{label}m",
        f"the yard under a light ({kind}) that is {label} m wide"
        + (" as seen from 4 m" if kind == "sun" else f", {height:g} m above it"),
        lambda: (under(scenes.yard(), scenes.lamp(kind, size, (0.3, -0.2, height))),),
        (PENUMBRA, ELSEWHERE),
        truth="exact" if exact else "rays",
    )


def _plate(id_: str, what: str, shape: shapes.Shape, *checks: Check, height: float = 1.0) -> Case:
    """A shape that must cast the shadow of the plain plate: the second frame is that plate."""
    return Case(
        id_,
        what,
        lambda: (scenes.plate(height), scenes.plate(height, shape=shape)),
        (SAME, PENUMBRA, ELSEWHERE, *checks),
    )


def _contact(gap: float) -> Case:
    return Case(
        f"contact-{gap:g}".replace("e-0", "e-"),
        f"a plate {gap:g} m over the ground, light 4 m above: b/r = {1 - gap / 4:.12g}",
        lambda: (scenes.plate(gap),),
        (PENUMBRA, ELSEWHERE),
    )


_X, _Y = (-1.0, 1.0), (-1.0, 1.0)


def _sun(elevation_rad: float, angle_rad: float = 0.01) -> Lamp:
    return Lamp(
        "sun",
        direction_ws=(-math.cos(elevation_rad), 0.0, -math.sin(elevation_rad)),
        sun_angle_rad=angle_rad,
    )


def _cones_in_cones() -> Setup:
    cones = [shapes.cone(0.25 * i, 0.4 * i + 0.2, 0.05 * i, 64) for i in range(1, 5)]
    return scenes.around(scenes.rectangle(0.6), Part("cones", shapes.merged(*cones)))


def _grass(count: int) -> Setup:
    return scenes.around(scenes.rectangle(0.6), Part("grass", shapes.blades(count, 2.5, 0.6, 0.02)), reach=20.0)


def _panes(count: int) -> Setup:
    """Many coplanar plates, overlapping."""
    panes = [shapes.sheet((-1.0, 0.6 - 0.05 * i), (-1.0 + 0.05 * i, 1.0)) for i in range(count)]
    return scenes.plate(1.0, shape=shapes.merged(*panes))


def _in_room(light: Lamp) -> Setup:
    room = shapes.inside_out(shapes.box((-6.0, -6.0, -0.01), (6.0, 6.0, 9.0)))
    return replace(
        scenes.around(light, Part("room", room), scenes.ball_part()), eye=replace(scenes.oblique(), near_m=12.0)
    )


def _animated(steps: int, frame: Callable[[float], Setup]) -> Build:
    return lambda: [frame(i / (steps - 1)) for i in range(steps)]


def _denormal() -> Setup:
    tiny = np.float32(1e-40)
    shape = shapes.merged(shapes.sheet(_X, _Y), (np.full((3, 3), tiny, np.float32), np.array([[0, 1, 2]], np.uint32)))
    return scenes.plate(1.0, shape=shape)


def _spot(size: float) -> Lamp:
    return scenes.lamp("spot", size)


_LIGHT_BOX = Part("lamp box", shapes.box((-0.4, -0.4, -0.4), (0.4, 0.4, 0.4)), (0.3, -0.2, 4.0))

CASES: tuple[Case, ...] = (
    Case("yard", "a ball and a fence over a ground under a square light", lambda: (scenes.yard(),),
         (PENUMBRA, ELSEWHERE)),
    *(_scaled(power) for power in (-6, -4, -2, 2, 4, 6)),
    *(_moved(power) for power in (3, 5, 7)),
    Case("turned", "the yard, turned about an odd axis",
         lambda: (scenes.yard(), carried(scenes.yard(), turn=odd_turn())), (SAME, SAME_MASK)),
    Case("reordered", "the yard's objects and triangles in another order",
         lambda: (scenes.yard(), reordered(scenes.yard())), (Check("same image", 0.005), SAME_MASK)),
    Case("near-far-1e7", "the yard, seen through clipping planes 10^7 apart",
         lambda: (scenes.yard(),
                  replace(scenes.yard(), eye=replace(scenes.oblique(), near_m=1e-3, far_m=1e4))),
         (Check("same image", 0.0), Check("same mask", 0.0))),
    Case("depths-1e6", "a light 1 km up, its caster 1 mm below it", lambda: (scenes.tower(1e3),),
         (PENUMBRA, ELSEWHERE)),
    Case("depths-1e7", "a light 10 km up, its caster 1 mm below it", lambda: (scenes.tower(1e4),),
         (PENUMBRA, ELSEWHERE)),
    # The light's size.
    *(_light_size("rectangle", size) for size in (0.0, 1e-9, 1e-3, 0.1, 1.0, 6.0, 60.0)),
    *(_light_size(kind, size) for kind in ("point", "spot", "sun", "ellipse", "line", "polygon")
      for size in (0.0, 60.0)),
    Case("scene-in-light", "the yard inside a sphere of light", lambda: (scenes.yard(60.0, "point"),),
         truth="rays"),
    Case("light-grows", "a half-plane's shadow while the light grows from 0 to 2 m",
         lambda: [under(scenes.edge(2.0), scenes.rectangle(size, (0.0, 0.0, 4.0)))
                  for size in (0.0, 0.1, 0.3, 0.6, 1.0, 2.0)], (MONOTONE,)),
    # The light's place.
    Case("light-touches-caster", "a plate in the light's own plane, edge to edge",
         lambda: (scenes.around(scenes.rectangle(0.6, (0.0, 0.0, 2.0)),
                                Part("plate", shapes.sheet((0.3, 1.5), (-1.0, 1.0)), (0.0, 0.0, 2.0)),
                                Part("post", shapes.box((-0.2, 0.4, 0.0), (0.2, 0.6, 1.0)))),),
         (PENUMBRA, ELSEWHERE)),
    Case("light-through-caster", "a plate that stands half through the light",
         lambda: (scenes.around(scenes.rectangle(0.6, (0.0, 0.0, 2.0)),
                                Part("plate", shapes.box((-0.05, -1.0, 1.7), (0.05, 1.0, 2.3)))),),
         (PENUMBRA, ELSEWHERE)),
    Case("light-in-caster", "a light inside a closed box",
         lambda: (scenes.around(scenes.rectangle(0.4), _LIGHT_BOX, scenes.ball_part()),), (PENUMBRA, ELSEWHERE)),
    Case("bulb-in-caster", "a sphere of light inside a closed box",
         lambda: (scenes.around(scenes.lamp("point", 0.4), _LIGHT_BOX, scenes.ball_part()),),
         (PENUMBRA, ELSEWHERE), truth="rays"),
    Case("bulb-in-room", "a sphere of light in a closed room",
         lambda: (_in_room(scenes.lamp("point", 0.4)),), (PENUMBRA, ELSEWHERE), truth="rays"),
    Case("light-behind-caster", "casters above the light, which shines away from them",
         lambda: (scenes.around(scenes.rectangle(0.6, (0.0, 0.0, 2.0)), scenes.ball_part((0.0, 0.0, 3.5))),),
         (PENUMBRA, ELSEWHERE)),
    Case("light-on-receiver", "a light lying on the ground, shining up at a ball",
         lambda: (scenes.around(replace(scenes.rectangle(0.6, (0.0, 0.0, 0.0)), direction_ws=(0.0, 0.0, 1.0)),
                                scenes.ball_part(radius=0.5)),), (PENUMBRA, ELSEWHERE)),
    Case("bulb-on-receiver", "a sphere of light sunk in the ground almost by half, beside a ball",
         lambda: (scenes.around(scenes.lamp("point", 0.6, (-1.0, 0.0, 0.05)), scenes.ball_part(radius=0.5)),),
         (PENUMBRA, ELSEWHERE), truth="rays"),
    Case("light-in-receiver-plane", "an upright light through the ground's plane, its centre 5 cm over it",
         lambda: (scenes.around(Lamp("rectangle", (-2.0, 0.0, 0.05), (1.0, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.3)),
                                scenes.ball_part(radius=0.5)),), (PENUMBRA, ELSEWHERE)),
    Case("light-in-plane-exactly", "a light of no height that lies in the ground's plane, seen from its side",
         lambda: (scenes.around(Lamp("line", (-2.0, 0.0, 0.0), half_u_ws=(0.0, 0.5, 0.0)),
                                scenes.ball_part(radius=0.5)),), (), truth="rays"),
    Case("sun-at-horizon", "a sun 0.1 degrees over the ground's horizon",
         lambda: (scenes.around(_sun(math.radians(0.1)), scenes.ball_part(radius=0.5)),),
         (PENUMBRA, ELSEWHERE), truth="rays"),
    Case("sun-on-horizon", "a sun whose centre stands on the horizon",
         lambda: (scenes.around(_sun(0.0), scenes.ball_part(radius=0.5)),), (), truth="rays"),
    # Contact.
    *(_contact(gap) for gap in (1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 0.0)),
    Case("contact-ulp", "a plate one float32 ulp over the ground, 1 m from the origin", lambda: (scenes.ulp_above(),),
         (PENUMBRA, ELSEWHERE)),
    Case("standing", "a box whose foot lies in the ground's plane", lambda: (scenes.standing(),),
         (PENUMBRA, ELSEWHERE)),
    # Meshes.
    _plate("slivers-1e6", "a plate with slivers of 10^6 : 1 in it", shapes.slivers(_X, _Y, 0.0, 1e6, 8)),
    _plate("zero-area", "a plate with triangles of no area", shapes.with_degenerates(shapes.sheet(_X, _Y))),
    _plate("doubled", "a plate whose faces are there two and three times", shapes.doubled(shapes.sheet(_X, _Y))),
    _plate("t-junctions", "a plate of two halves that meet in T-junctions", shapes.t_junctions(_X, _Y, 0.0, 7)),
    _plate("inside-out-sheet", "the plate with its back to the light", shapes.inside_out(shapes.sheet(_X, _Y))),
    Case("inside-out", "a closed box, and the same inside out",
         lambda: tuple(scenes.around(scenes.rectangle(0.4), Part("block", shape, (0.0, 0.0, 0.8)))
                       for shape in (shapes.box((-1, -1, 0), (1, 1, 0.5)),
                                     shapes.inside_out(shapes.box((-1, -1, 0), (1, 1, 0.5))))),
         (SAME, PENUMBRA, ELSEWHERE)),
    Case("open-mesh", "a ball without its upper half",
         lambda: (scenes.around(scenes.rectangle(0.6), Part("bowl", _bowl(), (0.0, 0.0, 1.4))),),
         (PENUMBRA, ELSEWHERE)),
    Case("coplanar-overlaps", "16 plates in one plane, one over the other", lambda: (_panes(16),),
         (PENUMBRA, ELSEWHERE)),
    Case("coplanar-receivers", "two grounds in one plane",
         lambda: (replace(scenes.yard(), parts=(replace(scenes.ground(10.0), name="second"), *scenes.yard().parts)),),
         (PENUMBRA, ELSEWHERE)),
    Case("vertex-1000-edges", "a fan of 500 vanes: 1,000 silhouette edges meet in one vertex",
         lambda: (scenes.around(scenes.rectangle(0.3), Part("fan", shapes.star(500, 0.7, 1.4, 0.0), (0.0, 0.0, 1.0))),),
         (PENUMBRA, ELSEWHERE)),
    Case("blades-10000", "10,000 thin blades of grass", lambda: (_grass(10_000),), (PENUMBRA, ELSEWHERE),
         truth="rays", ends_s=120.0),
    Case("cones-in-cones", "four cones, one inside the other, their tips standing out", lambda: (_cones_in_cones(),),
         (PENUMBRA, ELSEWHERE)),
    Case("denormal-corners", "a plate, and a triangle with denormal coordinates",
         lambda: (scenes.plate(1.0), _denormal()), (SAME, PENUMBRA, ELSEWHERE)),
    Case("denormal-light", "a light with denormal axes",
         lambda: (under(scenes.yard(), scenes.rectangle(0.0)),
                  under(scenes.yard(), scenes.rectangle(1e-310)),
                  under(scenes.yard(), scenes.rectangle(5e-324))), (Check("same image", 0.005),), truth="rays"),
    # Receivers and views.
    *(Case(f"grazing-{slope:g}", f"a light {slope:g} m over the ground for each metre of distance",
           partial(lambda s: (scenes.wall_grazed(s),), slope), (PENUMBRA, ELSEWHERE))
      for slope in (0.1, 0.01, 0.001)),
    Case("edge-on", "a wall that light and camera see from its edge", lambda: (scenes.edge_on(),),
         (PENUMBRA, ELSEWHERE)),
    Case("fov-1", "the yard through a lens of 1 degree",
         lambda: (scenes.seen(math.tan(math.radians(0.5)), (96, 72)),), (PENUMBRA, ELSEWHERE)),
    Case("fov-175", "the yard through a lens of 175 degrees",
         lambda: (scenes.seen(math.tan(math.radians(87.5)), (96, 72)),), (PENUMBRA, ELSEWHERE)),
    Case("image-1x1", "the yard in one pixel", lambda: (scenes.seen(0.15, (1, 1)),), ()),
    Case("image-8192x8", "the yard in 8192 x 8 pixels", lambda: (scenes.seen(0.15, (8192, 8)),),
         (PENUMBRA, ELSEWHERE), ends_s=120.0),
    # Many lights.
    Case("lights-1", "a small sphere of light, alone and asked alone", lambda: (scenes.many_lights(1),),
         (PENUMBRA, ELSEWHERE), truth="rays"),
    Case("lights-2000", "the same sphere of light among 1,999 others, and alone",
         lambda: (scenes.many_lights(2000),
                  under(replace(scenes.many_lights(2000), light=0), scenes.many_lights(2000).lamps[-1])),
         (Check("same image", 0.0),)),
    # Motion.
    Case("light-moves", "the yard's light moves by 2 cm in 9 frames",
         _animated(9, lambda t: under(scenes.yard(), scenes.rectangle(0.6, (0.3 + 0.02 * t, -0.2, 4.0)))),
         STEADY),
    Case("caster-moves", "the yard's ball rises by 2 cm in 9 frames",
         _animated(9, lambda t: replace(scenes.yard(), parts=tuple(
             replace(part, at=(0.4, 0.3, 1.2 + 0.02 * t)) if part.name == "ball" else part
             for part in scenes.yard().parts))), STEADY),
    Case("light-grows-slowly", "the yard's light grows by 2 cm in 9 frames",
         _animated(9, lambda t: scenes.yard(0.6 + 0.02 * t)), STEADY),
    Case("frames-24", "24 frames of two scenes in turn, in 32 x 24 pixels",
         lambda: [_small(setup) for _ in range(12) for setup in (scenes.yard(), scenes.standing())],
         (Check("no leak", 32.0),)),
    # Quality settings.
    Case("more-samples", "the yard with more and more samples", lambda: (scenes.yard(),),
         (Check("converges", -0.5),), sweep="samples"),
    Case("larger-maps", "the yard's point light with larger and larger maps", lambda: (scenes.yard(0.0),),
         (Check("converges", -0.3),), sweep="maps", truth="rays"),
    Case("not-a-number", "NaN and infinity in every field of scene, light, camera, mesh and settings", None,
         (Check("refused", 0.0),)),
)  # fmt: skip


QUICK = frozenset(
    {
        "yard", "scale-1e-6", "scale-1e6", "moved-1e7", "turned", "reordered", "depths-1e7",
        "light-rectangle-0m", "light-rectangle-60m", "light-sun-60m", "light-grows", "light-through-caster",
        "bulb-in-room", "light-in-receiver-plane", "sun-at-horizon", "contact-0.01", "contact-0", "contact-ulp",
        "slivers-1e6", "zero-area", "doubled", "inside-out", "vertex-1000-edges", "grazing-0.01", "fov-175",
        "image-1x1", "lights-2000", "light-moves", "not-a-number",
    }
)  # fmt: skip
"""A third of them, one of each kind: `penumbra stability --quick`."""


def _small(setup: Setup) -> Setup:
    return replace(setup, eye=replace(setup.eye, size_px=(32, 24)))


def _bowl() -> shapes.Shape:
    positions, triangles = shapes.ball(0.9)
    kept = triangles[(positions[triangles][:, :, 2] <= 1e-6).all(axis=1)]
    return positions, kept


def by_id(id_: str) -> Case:
    return next(case for case in CASES if case.id == id_)
