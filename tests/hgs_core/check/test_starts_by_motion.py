from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.starts_by_motion import clear_offsets, energy_offsets


def energies(shifts: list[float], frames: int = 60, noise: float = 0.05) -> list[np.ndarray]:
    """One irregular motion in cameras that began `shifts` frames late, each at its own strength."""
    numbers = np.random.default_rng(4)
    heights, places = numbers.uniform(1, 4, 30), numbers.uniform(-12, 75, 30)
    seen = []
    for number, shift in enumerate(shifts):
        t = np.arange(frames)[:, None] + shift
        signal = (heights * np.exp(-0.5 * ((t - places) / 1.5) ** 2)).sum(axis=1)
        seen.append((1 + 0.3 * number) * signal * (1 + numbers.normal(0, noise, frames)))
    return seen


def test_offsets_are_found_between_frames() -> None:
    shifts = [0.0, 3.0, 0.0, -5.0, 0.5, 0.0, 0.0]
    assert energy_offsets(energies(shifts)) == pytest.approx(shifts, abs=0.3)


def test_motions_that_are_not_alike_tell_nothing() -> None:
    numbers = np.random.default_rng(5)
    assert energy_offsets([numbers.random(60) for _ in range(6)]) == [None] * 6


def test_a_capture_of_few_frames_tells_nothing() -> None:
    assert energy_offsets(energies([0.0, 2.0, 0.0], frames=8)) == [None] * 3


def test_a_camera_without_energy_has_no_offset_and_spoils_no_other() -> None:
    shifts = [0.0, 3.0, 0.0, -5.0, 0.0]
    of_alive: list[np.ndarray | None] = list(energies(shifts))
    found = energy_offsets([*of_alive, None])
    assert found[-1] is None
    assert found[:-1] == pytest.approx(shifts, abs=0.3)


def test_a_dead_span_does_not_count() -> None:
    shifts = [0.0, 3.0, 0.0, -5.0, 0.0]
    seen = energies(shifts)
    seen[1][40:] = np.nan
    assert energy_offsets(seen) == pytest.approx(shifts, abs=0.3)


def test_an_offset_that_explains_much_is_clear() -> None:
    seen = energies([0.0, 3.0, 0.0, 0.0])
    offsets = energy_offsets(seen)
    assert clear_offsets(seen, offsets, 1.0) == offsets


def test_offsets_that_explain_no_more_than_none_would_are_all_unknown() -> None:
    """Each camera sees more of its own than all have in common."""
    numbers = np.random.default_rng(6)
    seen = [energy + 12 * numbers.random(60) for energy in energies([0.0, 0.0, 0.0, 0.0])]
    assert clear_offsets(seen, [0.0, 2.0, 0.0, 0.3], 1.0) == [None] * 4
    assert clear_offsets(seen, [0.0, 0.9, 0.0, 0.3], 1.0) == [0.0, 0.9, 0.0, 0.3]


def test_a_camera_without_energy_is_no_witness() -> None:
    seen: list[np.ndarray | None] = [*energies([0.0, 3.0, 0.0]), None]
    assert clear_offsets(seen, [0.0, 3.0, 0.0, None], 1.0) == [0.0, 3.0, 0.0, None]
