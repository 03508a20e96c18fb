"""Cycles, the independent truth: our unshadowed irradiance times our reference, pixel by pixel."""

from __future__ import annotations

from typing import Any

import pytest
from blender_kit import Kit, core
from cycles_truth import CASES, SCENES, Case, measure

SAMPLES = 64
EVERYWHERE = {"point, radius 0", "point, radius 0.3", "sun, angle 0.25", "rectangle", "ellipse"}
PAIRS = [(scene, case) for scene in SCENES for case in CASES if scene == "cards" or case.name in EVERYWHERE]


@pytest.fixture(scope="module")
def renderer() -> Any:
    return core.Renderer()


@pytest.mark.parametrize(("scene", "case"), PAIRS, ids=[f"{scene}: {case.name}" for scene, case in PAIRS])
def test_our_irradiance_is_that_of_cycles(kit: Kit, renderer: Any, scene: str, case: Case) -> None:
    agreement = measure(kit, renderer, scene, case, SAMPLES)
    assert agreement.left_out <= 5
    # A wrong factor in the watts, a wrong area or a wrong axis shows here first.
    assert abs(agreement.bias) < 1e-3
    assert agreement.median < agreement.noise + 1e-5
    # Pixels whose centre an edge touches, see docs/truth.md.
    assert agreement.at_edges < 1e-3 * agreement.pixels
    # Four standard errors, estimated from eight batches.
    assert agreement.elsewhere < 5e-4 * agreement.pixels
