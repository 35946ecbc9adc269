from __future__ import annotations

import random

import pytest

from benchmarks.soak.curve_slopes import LIMITS, SHORTEST, WARM_UP, Slope, slope_of, slopes
from benchmarks.soak.process_curves import Sample


def life(seconds: float, per_minute: float, noise: float = 0.0, start: float = 0.0) -> list[tuple[float, float]]:
    dice = random.Random(1)
    return [(start + t, 100 + per_minute * t / 60 + noise * dice.random()) for t in range(int(seconds))]


def test_a_steady_leak_is_measured_through_noise() -> None:
    assert slope_of([life(300, 1.0, noise=1.0)]) == pytest.approx(1.0, abs=0.4)


def test_the_warm_up_and_single_peaks_do_not_count() -> None:
    curve = [(float(t), 100 + min(t, WARM_UP) + (500 if t % 50 == 0 else 0)) for t in range(200)]
    assert slope_of([curve]) == 0


def test_a_step_after_a_fault_is_no_growth() -> None:
    assert slope_of([[(float(t), 100.0 if t < 160 else 103.0) for t in range(240)]]) == 0


def test_the_longest_life_decides() -> None:
    assert slope_of([life(150, 9.0), life(240, 2.0, start=400)]) == pytest.approx(2.0, abs=0.01)


def test_short_lives_have_no_slope() -> None:
    assert slope_of([life(WARM_UP + SHORTEST - 2, 9.0)]) is None


def test_a_slope_above_the_limit_is_too_steep() -> None:
    assert Slope("api", "memory", LIMITS["memory"] + 0.1).too_steep
    assert not Slope("api", "memory", LIMITS["memory"]).too_steep
    assert not Slope("api", "memory", None).too_steep


def test_a_new_process_is_a_new_life() -> None:
    samples = [Sample(float(t), 1 if t < 250 else 2, 100.0 if t < 250 else 900.0, 9, 3, 2) for t in range(500)]
    assert {slope.measure: slope.per_minute for slope in slopes({"api": samples})} == dict.fromkeys(LIMITS, 0.0)


def test_memory_needs_a_longer_life() -> None:
    samples = [Sample(float(t), 1, 100.0, 9, 3, 2) for t in range(200)]
    found = {slope.measure: slope.per_minute for slope in slopes({"api": samples})}
    assert found == dict.fromkeys(LIMITS, 0.0) | {"memory": None}
