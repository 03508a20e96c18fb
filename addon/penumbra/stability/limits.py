"""Where a method is wrong by construction: by how much it may be, where that is published or derived, and what the
plan does about it. What is in no row here must hold as the case says.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from .rows import Measured, Outcome, Row


@dataclass(frozen=True)
class Limit:
    techniques: tuple[str, ...]
    cases: tuple[str, ...]  # patterns as in file names
    property: str
    bound: float
    outcome: Outcome  # "bounded": the method's own error, within the figure; "known_limit": out of its field of use
    reason: str  # what is wrong, by how much, and where that is said
    warning: str = ""  # of the plan, which must say so: a part of its sentence

    def covers(self, technique: str, case: str, property_: str) -> bool:
        return (
            self.property == property_
            and technique in self.techniques
            and any(fnmatchcase(case, pattern) for pattern in self.cases)
        )


HARD = ("shadow_map", "shadow_volume", "hybrid", "pcf")
OUTER = ("smoothies", "penumbra_maps", "plateaus")
FACING = (*HARD, *OUTER, "linear_light_maps", "light_samples")
EVERYONE = (*FACING, "ray_traced", "masked_rays")
RAYS = ("ray_traced", "masked_rays")
ALL = ("*",)
AT_HORIZON = ("bulb-on-receiver", "light-in-receiver-plane", "sun-at-horizon", "grazing-0.01", "grazing-0.001")
BESIDE = ("light-touches-caster", "light-through-caster", "light-in-caster", "bulb-in-caster", "light-on-receiver")
DEEP = ("depths-*",)
LARGE = ("light-*-6m", "light-*-60m")
UNDER_A_PIXEL = ("light-rectangle-0.001m", "contact-0.01")

SAYS = "; the plan warns: "
# What the plan says, by a part of its sentence (passes/field_of_use.cpp).
ONE_POINT = "one point stands for it"
BLACK = "is drawn black all the way"
LONG = "too wide beside it"
ONE_LINE = "one line stands for it"
AT_LIGHT = "of the light, where depths are told apart from"
HORIZON = "lies under the surface's own plane"
FLOAT32 = "rays in float32 miss it"


def _bounded(techniques: tuple[str, ...], cases: tuple[str, ...], property_: str, bound: float, reason: str) -> Limit:
    return Limit(techniques, cases, property_, bound, "bounded", reason)


def _outside(
    techniques: tuple[str, ...], cases: tuple[str, ...], property_: str, bound: float, reason: str, warning: str = ""
) -> Limit:
    return Limit(techniques, cases, property_, bound, "known_limit", reason, warning)


LIMITS: tuple[Limit, ...] = (
    # Penumbrae, one family after the other; the closer bound first.
    _outside(HARD, ALL, "penumbra", 0.5,
             "one point stands for the light: 0 or 1 where the truth lies between, at most 1/2 off where the centre is "
             "seen exactly when half of the light is; 1/sqrt 12 = 0.289 on a straight edge (shadows 0.9)", ONE_POINT),
    _outside(HARD, (*LARGE, *BESIDE, *AT_HORIZON, *DEEP, *UNDER_A_PIXEL), "penumbra", 1.0,
             "the light's centre does not see what most of the light sees, or the penumbra is under a pixel wide and "
             "the figure is that of a few pixels", ONE_POINT),
    _bounded(OUTER, ALL, "penumbra", 0.446,
             "only the outer half of the penumbra is drawn, 0 at the hard edge where the truth is 1/2: RMSE 0.289 on a "
             "straight edge (plateaus B1), 0.309 to 0.446 with the smoothstep (penumbra maps 3.2, k up to 4)"),
    _bounded(OUTER, ALL, "penumbra", 0.6,
             "and at convex corners down to -0.77 for two edges each of which hides a half (penumbra maps 3.4 D)"),
    _outside(OUTER, ALL, "penumbra", 1.0,
             "the umbra never shrinks (plateaus B4, penumbra maps 3.4 B and C, smoothies 3): black where a light wider "
             "than its caster leaves no umbra, down to -1", BLACK),
    _outside(OUTER, ("light-line-*",), "penumbra", 1.0,
             "the umbra never shrinks, and a long line leaves none of what it passes on both sides", LONG),
    _outside(OUTER, (*BESIDE, *DEEP), "penumbra", 1.0,
             "edges at the light are cut off before anything is divided by their depth (penumbra maps 4, plateaus 4, "
             "smoothies 4: b/r -> 0)", AT_LIGHT),
    _outside(OUTER, AT_HORIZON, "penumbra", 1.0,
             "what of the light lies under a receiver's horizon counts as hidden", HORIZON),
    _outside(OUTER, ("vertex-1000-edges", "blades-10000"), "penumbra", 1.0,
             "thin wires, grass, particles: black, up to -1 (penumbra maps 3.4 C); no plan can tell them from boxes"),
    _bounded(OUTER, UNDER_A_PIXEL, "penumbra", 1.0,
             "a penumbra under a texel degrades to the hard edge (penumbra maps 4), and is a few pixels here"),
    _bounded(("linear_light_maps",), ALL, "penumbra", 0.15,
             "four lines or fewer stand for the light: edges along a line have no penumbra but that of the others, "
             "and thick casters are too light by their jump (X5)"),
    _outside(("linear_light_maps",), ALL, "penumbra", 0.3,
             "one line stands for a round light: edges along it are hard, 1/sqrt 12 at worst", ONE_LINE),
    _outside(("linear_light_maps",), (*BESIDE, *DEEP), "penumbra", 1.0,
             "depths clamp at the near plane: no skin at a caster that the light touches", AT_LIGHT),
    _outside(("linear_light_maps",), AT_HORIZON, "penumbra", 1.0,
             "what of the light lies under a receiver's horizon counts as hidden", HORIZON),
    _bounded(("linear_light_maps",), ("vertex-1000-edges", "blades-10000", *UNDER_A_PIXEL, "light-line-60m"),
             "penumbra", 1.0, "several casters in one segment (X6, X7): off by all the light between them; casters of "
             "a few texels may vanish"),
    _bounded(("light_samples", *RAYS), ALL, "penumbra", 0.125,
             "16 samples: 0.5/sqrt 16 at worst, 0.36 16^-0.75 = 0.045 on a straight edge"),
    _outside(("light_samples",), AT_HORIZON, "penumbra", 1.0,
             "what of the light lies under a receiver's horizon counts as hidden", HORIZON),
    _outside(("light_samples",), (*BESIDE, *DEEP), "penumbra", 1.0,
             "depths clamp at the near plane of each sample's map", AT_LIGHT),
    _outside(("light_samples",), ("light-*-60m",), "penumbra", 0.3,
             "a large part of the light lies under the horizon of faces that look aside; it counts as hidden", HORIZON),
    _bounded(("light_samples",), ("blades-10000", *UNDER_A_PIXEL), "penumbra", 1.0,
             "casters thinner than a texel are missed, bias errors do not average out (baselines 4)"),
    _outside(RAYS, DEEP, "penumbra", 1.0,
             "float32: contacts closer than 1e-6 of the scene's size are not told apart (ray tracing)", FLOAT32),
    # Umbra and light.
    _outside(RAYS, DEEP, "umbra and light", 1.0,
             "float32: contacts closer than 1e-6 of the scene's size are not told apart (ray tracing)", FLOAT32),
    _bounded(("pcf",), ALL, "umbra and light", 0.01,
             "the kernel is as wide near a contact as far from it (baselines 3), wider than the margin of two pixels"),
    _outside(FACING, AT_HORIZON, "umbra and light", 1.0,
             "what of the light lies under a receiver's horizon counts as hidden without a look (facing_test), while "
             "V is defined by casters alone; it adds nothing to the picture, its cosine being 0", HORIZON),
    _outside(OUTER, ("light-line-*",), "umbra and light", 1.0,
             "a penumbra is as wide along a silhouette's normal as the light is there, or as a disc of its mean "
             "width; a long line throws it along itself alone", LONG),
    _outside(("penumbra_maps",), BESIDE, "umbra and light", 1.0,
             "a disc of equal area stands for the rectangle: a caster in the light's own plane cuts into the disc",
             AT_LIGHT),
    _bounded(EVERYONE, ("contact-ulp",), "umbra and light", 0.05,
             "float32: at a few pixels the view cannot tell the plate from the ground one ulp below it and asks for "
             "the ground's V, which lies within every method's bias (contacts closer than 1e-6 of the scene's size)"),
    _bounded(("smoothies",), ("denormal-light",), "same image", 0.02,
             "a light of any extent has smoothies, however narrow: as t -> 0 the 2 x 2 filtered hard map is left, not "
             "the nearest texel's (smoothies 4, t = 0)"),
    # Convergence.
    _bounded(("linear_light_maps",), ("more-samples",), "converges", 0.0,
             "no rate is published: the error in a segment is its share 1/(N - 1) at most and falls where segments "
             "are bad (X6), slowly for thick casters (X5)"),
)  # fmt: skip


def judge(technique: str, case: str, found: Iterable[Measured], warnings: Sequence[str] = ()) -> list[Row]:
    """Figures become outcomes. Of several limits that cover one, the first counts that is wide enough and of which the
    plan warns, if it should."""
    return [_judged(technique, case, measured, warnings) for measured in found]


def _judged(technique: str, case: str, measured: Measured, warnings: Sequence[str]) -> Row:
    value, name = measured.value, measured.property
    if value <= measured.bound:
        return Row(technique, case, name, value, measured.bound, "holds")
    covering = [limit for limit in LIMITS if limit.covers(technique, case, name)]
    unsaid = []
    for limit in covering:
        if not value <= limit.bound:
            continue
        said = [warning for warning in warnings if limit.warning in warning]
        if not limit.warning:
            return Row(technique, case, name, value, limit.bound, limit.outcome, limit.reason)
        if said:
            return Row(technique, case, name, value, limit.bound, limit.outcome, f'{limit.reason}{SAYS}"{said[0]}"')
        unsaid.append(limit.warning)
    bound = max([measured.bound, *(limit.bound for limit in covering if limit.warning not in unsaid)])
    missing = "".join(f', and the plan does not warn "{text}"' for text in dict.fromkeys(unsaid))
    return Row(technique, case, name, value, bound, "violated", f"{value:.4g} is above {bound:.4g}{missing}")
