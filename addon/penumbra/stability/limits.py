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
MAPS = ("shadow_map", "hybrid", "pcf", *OUTER, "linear_light_maps", "light_samples")
FACING = (*HARD, *OUTER, "linear_light_maps", "light_samples")
EVERYONE = (*FACING, "ray_traced", "masked_rays")
ALL = ("*",)
HORIZON = ("bulb-on-receiver", "light-in-receiver-plane", "light-on-receiver", "sun-at-horizon", "grazing-*")
BESIDE = ("light-touches-caster", "light-through-caster", "light-in-caster", "bulb-in-caster", "light-on-receiver")
LARGE = ("light-*-6m", "light-*-60m")


def _bounded(techniques: tuple[str, ...], cases: tuple[str, ...], property_: str, bound: float, reason: str) -> Limit:
    return Limit(techniques, cases, property_, bound, "bounded", reason)


def _outside(
    techniques: tuple[str, ...], cases: tuple[str, ...], property_: str, bound: float, reason: str, warning: str = ""
) -> Limit:
    return Limit(techniques, cases, property_, bound, "known_limit", reason, warning)


LIMITS: tuple[Limit, ...] = (
    # Penumbrae.
    _bounded(HARD, ALL, "penumbra", 0.5,
             "one point stands for the light: 0 or 1 where the truth lies between, so at most 1/2 where the centre is "
             "seen exactly when half of the light is; a straight edge has 1/sqrt 12 = 0.289"),
    _outside(HARD, (*LARGE, *BESIDE, *HORIZON, "light-*-0.001m", "vertex-1000-edges", "blades-10000"), "penumbra", 1.0,
             "the light's centre does not see what most of the light sees"),
    _bounded(OUTER, ALL, "penumbra", 0.446,
             "only the outer half of the penumbra is drawn, 0 at the hard edge where the truth is 1/2: RMSE 0.289 on a "
             "straight edge (plateaus B1), 0.309 to 0.446 with the smoothstep (penumbra maps 3.2, k up to 4)"),
    _outside(OUTER, (*LARGE, *BESIDE, *HORIZON, "light-*-0.001m", "vertex-1000-edges", "blades-10000", "contact-*",
                     "standing", "edge-on", "bulb-in-room"),
             "penumbra", 1.0,
             "the umbra never shrinks (plateaus B4, penumbra maps 3.4 B and C, smoothies 3): black where a light wider "
             "than its caster leaves no umbra, down to -1"),
    _bounded(("linear_light_maps",), ALL, "penumbra", 0.3,
             "lines stand for the light: edges along a line have no penumbra (1/sqrt 12 at worst on a straight edge), "
             "thick casters are too light by their jump (X5)"),
    _outside(("linear_light_maps",), (*LARGE, *BESIDE, *HORIZON, "light-*-0.001m", "vertex-1000-edges"), "penumbra",
             1.0, "skins shorter than a texel, several casters in one segment (X6, X7), or no skin at a caster that "
             "the light touches"),
    _bounded(("light_samples", "ray_traced"), ALL, "penumbra", 0.125,
             "16 samples: 0.5/sqrt 16 at worst, 0.36 16^-0.75 = 0.045 on a straight edge"),
    _outside(("light_samples",), (*LARGE, *HORIZON, "light-*-0.001m", "blades-10000"), "penumbra", 1.0,
             "each sample has a map of its own: features thinner than a texel are missed, and what lies under a "
             "receiver's horizon counts as hidden"),
    # Umbra and light.
    _bounded(("pcf",), ALL, "umbra and light", 0.01,
             "the kernel is as wide near a contact as far from it (baselines 3), wider than the margin of two pixels"),
    _outside(FACING, HORIZON, "umbra and light", 1.0,
             "what of the light lies under a receiver's horizon counts as hidden without a look (facing_test), while "
             "V is defined by casters alone; it adds nothing to the picture, its cosine being 0"),
    _outside(("smoothies", "penumbra_maps", "plateaus"), ("light-line-*",), "umbra and light", 1.0,
             "a penumbra is as wide along a silhouette's normal as the light is there, or as a disc of its mean "
             "width; a long line throws it along itself alone"),
    _outside(("penumbra_maps",), BESIDE, "umbra and light", 1.0,
             "a disc of equal area stands for the rectangle: a caster in the light's own plane cuts into the disc"),
    _outside(EVERYONE, ("contact-ulp",), "umbra and light", 0.05,
             "float32: at a few pixels the view cannot tell the plate from the ground one ulp below it and asks for "
             "the ground's V, which lies within every method's bias (contacts closer than 1e-6 of the scene's size)"),
    # Motion and convergence.
    _bounded(("linear_light_maps",), ("more-samples",), "converges", 0.0,
             "no rate is published: the error in a segment is its share 1/(N - 1) at most and falls where segments "
             "are bad (X6), slowly for thick casters (X5)"),
)  # fmt: skip


def judge(technique: str, case: str, found: Iterable[Measured], warnings: Sequence[str] = ()) -> list[Row]:
    """Figures become outcomes. Of several limits that cover one, the first that is wide enough counts."""
    return [_judged(technique, case, measured, warnings) for measured in found]


def _judged(technique: str, case: str, measured: Measured, warnings: Sequence[str]) -> Row:
    value, name = measured.value, measured.property
    if value <= measured.bound:
        return Row(technique, case, name, value, measured.bound, "holds")
    covering = [limit for limit in LIMITS if limit.covers(technique, case, name)]
    for limit in covering:
        if value <= limit.bound:
            if limit.warning and not any(limit.warning in warning for warning in warnings):
                reason = f'{limit.reason}; the plan should warn "{limit.warning}" and does not'
                return Row(technique, case, name, value, measured.bound, "violated", reason)
            said = f'; the plan warns: "{warnings[0]}"' if limit.warning else ""
            return Row(technique, case, name, value, limit.bound, limit.outcome, limit.reason + said)
    bound = max([measured.bound, *(limit.bound for limit in covering)])
    return Row(technique, case, name, value, bound, "violated", f"{value:.4g} is above {bound:.4g}")
