"""How well an error figure is known, against what repetition scatters."""

from __future__ import annotations

import numpy as np
import pytest
from penumbra.precision import headline_error

SHAPE = (60, 80)
NONE = np.zeros(SHAPE, np.float32)
ALL = np.ones(SHAPE, np.uint8)


def ramp() -> np.ndarray:
    return np.broadcast_to(np.linspace(-0.2, 1.2, SHAPE[1]), SHAPE).clip(0, 1).astype(np.float32)


def rmse(pictures: list[np.ndarray], truth: np.ndarray) -> float:
    inside = (truth > 1e-4) & (truth < 1 - 1e-4)
    return float(np.sqrt(np.mean([(picture - truth)[inside] ** 2 for picture in pictures])))


def test_a_deterministic_picture_against_an_exact_reference_is_known_exactly() -> None:
    assert headline_error([ramp() * np.float32(0.9)], ramp(), NONE, ALL) == 0.0


@pytest.mark.parametrize("seeds", [2, 4])
def test_of_a_noisy_technique_it_is_what_fresh_seeds_scatter(seeds: int) -> None:
    generator, truth = np.random.default_rng(3), ramp()

    def run() -> list[np.ndarray]:
        return [(generator.binomial(16, truth) / 16).astype(np.float32) for _ in range(seeds)]

    scatter = np.std([rmse(run(), truth) for _ in range(300)])
    told = np.mean([headline_error(run(), truth, NONE, ALL) for _ in range(20)])
    assert told == pytest.approx(scatter, rel=0.15)


def test_the_references_own_noise_counts_as_error_and_the_figure_says_by_how_much() -> None:
    generator, truth = np.random.default_rng(4), ramp()
    answer = truth + np.float32(0.004) * np.sin(np.arange(SHAPE[1])).astype(np.float32)
    noise = np.full(SHAPE, 0.002, np.float32)
    noisy = (truth + 0.002 * generator.standard_normal(SHAPE)).clip(2e-4, 1 - 2e-4).astype(np.float32)
    inside = (truth > 0.02) & (truth < 0.98)  # where nothing was clipped
    mask = inside.astype(np.uint8)
    honest = float(np.sqrt(np.mean((answer - truth)[inside] ** 2)))
    seen = float(np.sqrt(np.mean((answer - noisy)[inside] ** 2)))
    told = headline_error([answer], noisy, noise, mask)
    assert seen > honest
    assert seen - honest < 2 * told < 4 * (seen - honest)


def test_an_error_of_nothing_is_known_no_better_than_the_reference() -> None:
    noise = np.full(SHAPE, 0.002, np.float32)
    assert headline_error([ramp()], ramp(), noise, ALL) == pytest.approx(0.002, rel=1e-6)


def test_without_a_penumbra_the_whole_mask_counts_and_without_a_mask_nothing() -> None:
    truth = (ramp() > 0.5).astype(np.float32)
    a, b = truth.copy(), truth.copy()
    a[0, 0] = 1 - a[0, 0]
    assert headline_error([a, b], truth, NONE, ALL) > 0.0
    assert headline_error([a, b], truth, NONE, np.zeros(SHAPE, np.uint8)) == 0.0


def test_a_value_that_is_not_a_number_counts_as_an_error_of_one() -> None:
    truth = ramp()
    broken = truth.copy()
    broken[0, 40] = np.nan
    assert np.isfinite(headline_error([broken, truth], truth, NONE, ALL))
