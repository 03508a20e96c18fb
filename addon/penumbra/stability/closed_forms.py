"""What each method may answer, pixel by pixel, by its own closed form: the bounds of `penumbra stability`.

A form looks at the truth and the scene, never at what a technique drew. It gives the least and the greatest V that the
method's construction allows at each pixel; the bound of a case is the figure of the worst picture between them. Sources
are keys of docs/references.bib; the derivations stand beside the forms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from . import properties
from .ground import Ground, Reals
from .properties import Image

Flags = npt.NDArray[np.bool_]

SAMPLES: Mapping[str, int] = {"light_samples": 16, "ray_traced": 16, "masked_rays": 256}
"""Points of the light for each pixel by default."""
EDGE_TEXELS: Mapping[str, float] = {"shadow_map": 1.0, "pcf": 4.0}
"""So far from the hard edge a map decides: a texel, half of a box of 7 and its bilinear rim. Volumes know no texels."""
LINES = 4
"""That stand for a square."""
AVERAGES = ("pcf", "light_samples")
"""What takes the mean of many comparisons for each pixel."""
TAPS: Mapping[str, float] = {"pcf": 4.0, "smoothies": 1.0}
"""Texels to the farthest comparison; half a one in a nearest texel."""
SLOPE_CAP = 64.0
"""The greatest bias, in texels."""
HALF_TEXEL = 0.75
"""Half of a texel's diagonal, and a little."""
NOTHING = 0.99
"""A bound of so much of the worst picture's figure says nothing."""
ROUNDING = 1e-6
"""Of float32 pictures."""
ROUNDINGS = 4.0
"""Of float32, in the places of a ray's two ends and of a corner of what it meets, in units of the scene's size."""
STRAIGHT_EDGES = 0.446
"""RMSE of the outer half under the smoothstep, receiver 4 times as deep as the edge [WymanHansen2003]."""
ONE_STEP = 1.0 / math.sqrt(12.0)
"""RMSE over a linear ramp of one step in its middle: the integral of x^2 from -1/2 to 1/2 is 1/12."""


@dataclass(frozen=True)
class Allowed:
    """V may lie from `low` to `high`, scatter about that by `noise` (RMS), and be anything at a share of the pixels."""

    low: Reals
    high: Reals
    noise: Reals | float = 0.0
    flips: Reals | float = 0.0

    def figure(self, property_: str, ground: Ground) -> float:
        """What a property measures at worst."""
        truth, mask = ground.truth, ground.mask
        off = np.maximum(truth - self.low, self.high - truth)
        if property_ == "umbra and light":
            calm = properties.away_from_edges(truth, mask, properties.MARGIN_PX)
            off = np.maximum(off > properties.VISIBLE_STEP, self.flips)
            return float(np.mean(off[calm])) + ROUNDING if calm.any() else 0.0
        asked = properties.in_penumbra(truth, mask) if property_ == "penumbra" else mask != 0
        if not asked.any():
            return 0.0
        noise, flips = np.broadcast_to(self.noise, off.shape), np.broadcast_to(self.flips, off.shape)
        return _rms(off[asked]) + _rms(noise[asked]) + _rms(np.sqrt(flips[asked])) + ROUNDING

    def outside(self, image: Image, ground: Ground) -> float:
        """Share of the pixels at which a picture is visibly not what the form says."""
        asked = ground.mask != 0
        reach = properties.VISIBLE_STEP + 3.0 * np.broadcast_to(self.noise, image.shape)
        off = (image < self.low - reach) | (image > self.high + reach)
        allowed = np.mean(np.broadcast_to(self.flips, image.shape)[asked])
        return max(float(np.mean(off[asked]) - allowed), 0.0)


Form = Callable[[Ground, str], Allowed]


def _scatter(truth: Reals, technique: str) -> Reals:
    return np.asarray(np.sqrt(np.clip(truth * (1.0 - truth), 0.0, 1.0) / SAMPLES.get(technique, 1)))


def _rms(values: Reals) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))


def _any(ground: Ground, where: Flags, allowed: Allowed) -> Allowed:
    """Where the light's border is within reach of a texel, the answer may be that of either side."""
    low, high = np.where(where, 0.0, allowed.low), np.where(where, 1.0, allowed.high)
    return replace(allowed, low=low, high=high)


def hard(ground: Ground, technique: str) -> Allowed:
    """[Williams1978], [Crow1977]: the light's centre is seen (1) or not (0), where the surface's plane does not hide
    it; on either side of that edge within a texel, for `pcf` within half of its kernel."""
    centre = ground.centre_seen.astype(np.float64)
    return _any(ground, ground.at_hard_edge(EDGE_TEXELS.get(technique, 0.0)), Allowed(centre, centre))


def outer(ground: Ground, technique: str) -> Allowed:
    """Black where the centre is hidden; outside, with lambda the distance of the casters, carried to the light's plane,
    from its centre in units of its shape (plateaus E1), lambda for plateaus [Haines2001], its sinusoid for smoothies
    [ChanDurand2003], S(I) with I = t / (t + (1 - t) k) for penumbra maps [WymanHansen2003]: any number of casters, as
    the darkest wins and lambda is the least. Within a texel as much as lambda varies there."""
    low, high = ground.distances(_GAUGES[technique])
    if technique == "plateaus":
        dark, bright = low, high
    elif technique == "smoothies":
        dark, bright = _sinusoid(low), _sinusoid(high)
    else:
        t = low / (low + (1.0 - low) * ground.depth_ratio)
        # Polygons and lines have the linear ramp, round lights the smoothstep.
        dark, bright = np.minimum(t, _smoothstep(t)), np.maximum(high, _smoothstep(high))
    # Silhouettes are those that the centre sees (E2): not the rims over which parts of a caster hide the light from
    # its own surface. Plateaus take the hard comparison there, as on all that lies in no plane.
    bright = np.where(ground.in_a_plane, bright, 1.0)
    seen = ground.centre_seen
    dark, bright = np.where(seen, dark, 0.0), np.where(seen, bright, 0.0)
    allowed = Allowed(ground.least_around(dark), ground.greatest_around(bright))
    return _any(ground, ground.at_hard_edge(HALF_TEXEL), allowed)


def straight(ground: Ground, technique: str) -> Allowed:
    """`outer`, and no more than the RMSE of its half of a straight edge's penumbra, 0.446."""
    off = np.where(properties.in_penumbra(ground.truth, ground.mask), STRAIGHT_EDGES, 0.0)
    return Allowed(ground.truth - off, ground.truth + off)


def sampled(ground: Ground, technique: str) -> Allowed:
    """[CookPorterCarpenter1984]: n points of the light scatter by sqrt(V (1 - V) / n) at most, jittered ones by less.
    Maps move each one's edge by up to a texel [HeckbertHerf1997]."""
    truth = ground.truth.astype(np.float64)
    noise = _scatter(truth, technique)
    if technique == "light_samples":
        return Allowed(ground.least_around(truth), ground.greatest_around(truth), noise)
    return Allowed(truth, truth, noise)


def one_step(ground: Ground, technique: str) -> Allowed:
    """No skin: of the two ends of a line, each hard, one or both are seen: steps of 1/2, ONE_STEP over a ramp, as far
    as a texel moves it."""
    truth = ground.truth.astype(np.float64)
    off = np.where(properties.in_penumbra(ground.truth, ground.mask), ONE_STEP, 0.0)
    low, high = ground.least_around(truth), ground.greatest_around(truth)
    allowed = Allowed(np.minimum(truth - off, low), np.maximum(truth + off, high))
    return _any(ground, ground.at_hard_edge(HALF_TEXEL), allowed)


def missed(ground: Ground, technique: str) -> Allowed:
    """A caster that is missed brightens, and nothing darkens."""
    return Allowed(ground.truth.astype(np.float64), np.ones(ground.truth.shape))


def hit_or_missed(ground: Ground, technique: str) -> Allowed:
    """A caster thinner than a texel hides it whole or not at all, in proportion to its width (hybrid 3.1, 6): V is 0 or
    1 with the truth as its mean, an RMS of sqrt(V (1 - V)) even if all samples share the texel."""
    truth = ground.truth.astype(np.float64)
    return Allowed(truth, truth, _scatter(truth, ""))


def not_told_apart(ground: Ground, technique: str) -> Allowed:
    """Float32 places a caster by ROUNDINGS: where its shadow, grown by them, may fall, V is any; elsewhere 1."""
    where = ground.near_shadow(ROUNDINGS)
    return Allowed(np.where(where, 0.0, 1.0), np.ones(where.shape))


def under_horizon(form: Form) -> Form:
    """What of the light lies under the surface's own plane counts as hidden, at most that share is lost."""

    def less(ground: Ground, technique: str) -> Allowed:
        allowed = form(ground, technique)
        lost = np.minimum(ground.under_horizon, ground.truth)
        low = np.maximum(allowed.low - lost, 0.0)
        if technique == "linear_light_maps":  # counted in whole lines
            low = np.where(lost > 0.0, np.maximum(low - 0.5 / LINES, 0.0), low)
        if technique not in SAMPLES:
            return replace(allowed, low=low)
        seen = ground.truth - lost
        nearest = np.clip(0.5, seen, ground.truth)  # V (1 - V) is greatest there
        return replace(allowed, low=low, noise=_scatter(nearest, technique))

    less.__doc__ = under_horizon.__doc__
    return less


def with_acne(form: Form) -> Form:
    """Where R g, for taps within R texels and a slope of g, is above the greatest bias B, a share of 1/2 - B / (2 R g)
    of the taps is in the shade of their own surface [Williams1978] (baselines 1)."""

    def less(ground: Ground, technique: str) -> Allowed:
        allowed = form(ground, technique)
        steepest = TAPS.get(technique, 0.5) * np.maximum(ground.slope, 1e-300)
        share = 0.5 * np.maximum(1.0 - SLOPE_CAP / steepest, 0.0)
        if technique in AVERAGES:
            return replace(allowed, low=np.maximum(allowed.low - share, 0.0))
        return replace(allowed, flips=share)

    less.__doc__ = with_acne.__doc__
    return less


def filtered(ground: Ground, technique: str) -> Allowed:
    """Beside the nearest texel's answer, the mean of the four around: half off, within a texel of the hard edge."""
    off = np.where(ground.at_hard_edge(1.0), 0.5, 0.0)
    return Allowed(ground.truth - off, ground.truth + off)


FORMS: Mapping[str, Form] = {
    "hard": hard,
    "outer": outer,
    "straight": straight,
    "sampled": sampled,
    "one step": one_step,
    "missed": missed,
    "hit or missed": hit_or_missed,
    "outer, horizon": under_horizon(outer),
    "sampled, horizon": under_horizon(sampled),
    "one step, horizon": under_horizon(one_step),
    "filtered": filtered,
    "not told apart": not_told_apart,
    "hard, acne": with_acne(hard),
    "outer, acne": with_acne(under_horizon(outer)),
    "one step, acne": with_acne(under_horizon(one_step)),
    "sampled, acne": with_acne(under_horizon(sampled)),
}


def told(forms: Mapping[str, Allowed], property_: str, ground: Ground) -> tuple[dict[str, float], bool]:
    """The bounds of the forms that some picture could break, and whether there are others: those say nothing."""
    shape = ground.truth.shape
    any_picture = Allowed(np.zeros(shape), np.ones(shape)).figure(property_, ground)
    bounds = {name: allowed.figure(property_, ground) for name, allowed in forms.items()}
    if "straight" in bounds and "outer" in bounds:
        bounds["straight"] = min(bounds["straight"], bounds["outer"])
    known = {name: bound for name, bound in bounds.items() if bound < NOTHING * any_picture}
    return known, len(known) < len(bounds)


_GAUGES: Mapping[str, tuple[str, ...]] = {
    "plateaus": ("outline",),
    "smoothies": ("own", "disc"),  # as wide as the light across an edge, circles around corners
    "penumbra_maps": ("disc",),
}


def _sinusoid(v: Reals) -> Reals:
    return np.asarray(0.5 - 0.5 * np.cos(math.pi * v))


def _smoothstep(t: Reals) -> Reals:
    return np.asarray(t * t * (3.0 - 2.0 * t))
