"""Where a method is wrong by construction: by how much it may be, where that is published or derived, and what the
plan does about it. What is in no row here must hold as the case says.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from .rows import Measured, Outcome, Row


@dataclass(frozen=True)
class Limit:
    techniques: tuple[str, ...]
    cases: tuple[str, ...]  # patterns as in file names
    property: str
    bound: float | str  # a figure; or the key of a closed form (closed_forms.FORMS), worked out for each case
    outcome: Outcome  # "bounded": the method's own error, within the figure; "known_limit": out of its field of use
    reason: str  # what is wrong, by how much, and where that is said
    warning: str = ""  # of the plan, which must say so: a part of its sentence

    def covers(self, technique: str, case: str, property_: str) -> bool:
        """The whole picture, or each of its pixels, is asked where a closed form says nothing of what was."""
        asked = self.property == property_ or (property_ in ("picture", "own form") and isinstance(self.bound, str))
        return asked and technique in self.techniques and any(fnmatchcase(case, pattern) for pattern in self.cases)

    def figure(self, measured: Measured) -> float:
        """Up to where this limit goes; minus infinity where its form was not worked out, or says nothing."""
        if isinstance(self.bound, str):
            return measured.forms.get(self.bound, -math.inf)
        return self.bound


HARD = ("shadow_map", "shadow_volume", "hybrid", "pcf")
OUTER = ("smoothies", "penumbra_maps", "plateaus")
FACING = (*HARD, *OUTER, "linear_light_maps", "light_samples")
RAYS = ("ray_traced", "masked_rays")
ALL = ("*",)
PENUMBRAE = ("penumbra", "umbra and light")
AT_HORIZON = (
    "bulb-on-receiver", "light-on-receiver", "light-in-receiver-plane", "sun-at-horizon", "grazing-*", "light-*-60m",
)  # fmt: skip
BESIDE = ("light-touches-caster", "light-through-caster", "light-in-caster", "bulb-in-caster", "light-on-receiver")
DEEP = ("depths-*",)
LARGE = ("light-*-6m", "light-*-60m")
THIN = ("vertex-1000-edges", "blades-10000")

SAYS = "; the plan warns: "
# What the plan says, by a part of its sentence (passes/field_of_use.cpp).
ONE_POINT = "one point stands for it"
BLACK = "is drawn black all the way"
LONG = "too wide beside it"
ONE_LINE = "one line stands for it"
AT_LIGHT = "of the light, where depths are told apart from"
HORIZON = "lies under the surface's own plane"
FLOAT32 = "rays in float32 miss it"


def _rows(
    outcome: Outcome,
    techniques: tuple[str, ...],
    cases: tuple[str, ...],
    bound: float | str,
    reason: str,
    warning: str = "",
) -> tuple[Limit, ...]:
    return tuple(Limit(techniques, cases, name, bound, outcome, reason, warning) for name in PENUMBRAE)


_HALF = (
    "only the outer half of the penumbra is drawn, 0 at the hard edge where the truth is 1/2: RMSE 0.289 on a straight "
    "edge (plateaus B1), 0.309 to 0.446 with the smoothstep (penumbra maps 3.2, receiver up to 4 times as deep)"
)
_HIDDEN = "what of the light lies under a surface's own plane counts as hidden without a look (facing_test)"
_GRAZED = "; where light grazes more steeply than the bias is made for, acne is accepted (slope_cap)"

LIMITS: tuple[Limit, ...] = (
    # Penumbrae, umbra and light, one family after the other; the closer bound first.
    *_rows("bounded", (*FACING, *RAYS), ("contact-ulp",), "missed",
           "float32: the view cannot tell the plate from the ground one ulp below it, and at some pixels asks for the "
           "ground's V; the plate is within every method's bias of it, and is missed"),
    *_rows("known_limit", HARD, ALL, "hard",
           "hard shadows have no penumbra: 0 or 1 where the truth lies between, as the light's centre is hidden or "
           "seen; 1/sqrt 12 = 0.289 on a straight edge (shadows 0.9)", ONE_POINT),
    *_rows("known_limit", HARD, AT_HORIZON, "hard, acne",
           "hard shadows have no penumbra" + _GRAZED, HORIZON),
    *_rows("bounded", OUTER, ALL, "straight", _HALF),
    *_rows("known_limit", OUTER, LARGE, "outer",
           "the umbra never shrinks (plateaus B4, penumbra maps 3.4 B and C, smoothies 3): black where a light wider "
           "than its caster leaves no umbra", BLACK),
    *_rows("known_limit", OUTER, ("light-line-*",), "outer",
           "a penumbra is as wide along a silhouette's normal as the light is there, or as a disc of its mean width; "
           "a long line throws it along itself alone", LONG),
    *_rows("known_limit", OUTER, ("light-touches-caster", "light-through-caster", *DEEP), "outer",
           "edges at the light are cut off before anything is divided by their depth (penumbra maps 4, plateaus 4, "
           "smoothies 4: b/r -> 0); a disc of equal area reaches beyond the light's own sides", AT_LIGHT),
    *_rows("known_limit", OUTER, AT_HORIZON, "outer, horizon", _HIDDEN, HORIZON),
    *_rows("known_limit", OUTER, AT_HORIZON, "outer, acne", _HIDDEN + _GRAZED, HORIZON),
    *_rows("bounded", OUTER, ALL, "outer",
           "darker than on a straight edge at convex corners, down to -0.77 (penumbra maps 3.4 D), and black behind "
           "what is thinner than the light (3.4 C); lighter in gaps and holes (plateaus B3); hard under a texel"),
    *_rows("known_limit", ("linear_light_maps",), ALL, "one step",
           "one line stands for a round light: edges along it are hard, as one step of a ramp", ONE_LINE),
    *_rows("known_limit", ("linear_light_maps",), (*BESIDE, *DEEP), "one step",
           "depths clamp at the near plane: no skin at a caster that the light touches, but its two ends' hard "
           "shadows", AT_LIGHT),
    *_rows("known_limit", ("linear_light_maps",), AT_HORIZON, "one step, horizon", _HIDDEN, HORIZON),
    *_rows("known_limit", ("linear_light_maps",), AT_HORIZON, "one step, acne", _HIDDEN + _GRAZED, HORIZON),
    *_rows("bounded", ("linear_light_maps",), ALL, "one step",
           "where a skin is missing (several casters in one segment X6, X7, under a texel) the ends' hard shadows are "
           "left"),
    *_rows("bounded", ("linear_light_maps", "light_samples"), THIN, "hit or missed",
           "a caster thinner than a texel is hit or missed as a whole, and one skin hides another (X7)"),
    *_rows("bounded", ("light_samples", *RAYS), ALL, "sampled",
           "so many points stand for the light: 0.5/sqrt n at worst, 0.36 n^-0.75 on a straight edge (baselines 6), "
           "each with a map's texels"),
    *_rows("known_limit", ("light_samples",), AT_HORIZON, "sampled, horizon", _HIDDEN, HORIZON),
    *_rows("known_limit", ("light_samples",), AT_HORIZON, "sampled, acne", _HIDDEN + _GRAZED, HORIZON),
    *_rows("known_limit", RAYS, DEEP, "missed",
           "float32: a caster closer to the light than 1e-6 of the scene's size is not found", FLOAT32),
    *_rows("known_limit", RAYS, DEEP, "not told apart",
           "float32: a caster closer to the light than 1e-6 of the scene's size is as large as its rounding", FLOAT32),
    # Pictures that should be the same.
    Limit(("smoothies",), ("denormal-light",), "same image", "filtered", "bounded",
          "a light of any extent has smoothies, however narrow: as t -> 0 the 2 x 2 filtered hard map is left, not "
          "the nearest texel's (smoothies 4, t = 0)"),
    # Memory.
    Limit(("linear_light_maps",), ("frames-24",), "no leak", 256.0, "bounded",
          "a software device lets go of a deleted texture only when its queue of pictures comes round to it, so that "
          "up to four maps of 64 MB stay for a while: over 384 frames the memory swings between 200 and 500 MB and "
          "does not grow"),
    # Convergence.
    Limit(("linear_light_maps",), ("more-samples",), "converges", 0.0, "bounded",
          "no rate is published: the error in a segment is its share 1/(N - 1) at most and falls where segments are "
          "bad (X6), slowly for thick casters (X5)"),
)  # fmt: skip


def forms_of(technique: str, case: str, property_: str) -> list[str]:
    """The closed forms that a figure may be held against."""
    named = (limit.bound for limit in LIMITS if limit.covers(technique, case, property_))
    return list(dict.fromkeys(bound for bound in named if isinstance(bound, str)))


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
        figure = limit.figure(measured)
        if not value <= figure:
            continue
        said = [warning for warning in warnings if limit.warning in warning]
        if not limit.warning:
            return Row(technique, case, name, value, figure, limit.outcome, limit.reason)
        if said:
            return Row(technique, case, name, value, figure, limit.outcome, f'{limit.reason}{SAYS}"{said[0]}"')
        unsaid.append(limit.warning)
    bound = max([measured.bound, *(limit.figure(measured) for limit in covering if limit.warning not in unsaid)])
    missing = "".join(f', and the plan does not warn "{text}"' for text in dict.fromkeys(unsaid))
    return Row(technique, case, name, value, bound, "violated", f"{value:.4g} is above {bound:.4g}{missing}")
