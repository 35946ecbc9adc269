"""Lives end where the masks see a ghost."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch

from hgs_core.scene import DynamicSplats
from hgs_core.scene.temporal import evaluate
from hgs_core.train.control.ghosts import visible_where_still, with_lives_shortened
from tests.hgs_core.render.scenes import dynamic_splats
from tests.synthetic import ring_of_cameras

MOMENTS = np.linspace(0, 1, 11)


def splats(centers: list[float], half_life: float = 0.2, coefficients: int = 4) -> DynamicSplats[torch.Tensor]:
    """Splats that move and turn, opaque at their centres."""
    count = len(centers)
    return dataclasses.replace(
        dynamic_splats(count, dtype=torch.float32, coefficients=coefficients),
        opacity_logits=torch.full((count,), 4.0),
        time_centers=torch.tensor(centers),
        time_log_precisions=torch.full((count,), math.log(math.log(2) / half_life**2)),
    )


def at(dynamic: DynamicSplats[torch.Tensor], moment: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return evaluate(dynamic.map(lambda array: array.numpy()), moment)


def ghosts(*moments: float) -> np.ndarray:
    return np.isclose(MOMENTS[:, None], moments).any(1)[:, None]


def test_a_life_ends_where_it_would_be_a_ghost_and_keeps_its_other_end() -> None:
    before = splats([0.5])
    after, changed = with_lives_shortened(before, MOMENTS, ghosts(0.3, 0.2))
    assert changed.all()
    peak = float(torch.sigmoid(after.opacity_logits))
    assert at(after, 0.3)[2] / peak < 0.051
    assert float(after.time_centers) > 0.5
    end = 0.5 + 0.2 * math.sqrt(-math.log(0.05) / math.log(2))  # a twentieth of the Gaussian's peak
    np.testing.assert_allclose(at(before, end)[2], at(after, end)[2], rtol=1e-4)


def test_both_ends_are_cut_where_both_are_ghosts() -> None:
    after, _ = with_lives_shortened(splats([0.55]), MOMENTS, ghosts(0.2, 0.3, 0.7))
    np.testing.assert_allclose(float(after.time_centers), 0.5, atol=1e-6)
    np.testing.assert_allclose(at(after, 0.3)[2], at(after, 0.7)[2], rtol=1e-4)


@pytest.mark.parametrize("coefficients", [4, 6])
def test_path_and_turning_stay_the_same_functions_of_time(coefficients: int) -> None:
    """Reference: the equations of time on the splats as they were."""
    before = splats([0.5, 0.4, 0.6], coefficients=coefficients)
    after, changed = with_lives_shortened(before, MOMENTS, np.repeat(ghosts(0.2), 3, 1))
    assert changed.all()
    for moment in (0.35, 0.5, 0.8):
        for was, now in zip(at(before, moment)[:2], at(after, moment)[:2], strict=True):
            np.testing.assert_allclose(now, was, atol=1e-5)


def test_splats_without_ghosts_and_those_that_are_nothing_else_stay_as_they_are() -> None:
    before = splats([0.5, 0.5])
    seen = np.stack([np.zeros(11, np.bool_), np.ones(11, np.bool_)], 1)
    after, changed = with_lives_shortened(before, MOMENTS, seen)
    assert not changed.any()
    for (name, was), (_, now) in zip(before.items(), after.items(), strict=True):
        torch.testing.assert_close(now, was, msg=name)


def test_a_ghost_is_visible_where_nothing_moves_and_the_picture_is_wrong() -> None:
    cameras = ring_of_cameras(3, 32, 24)
    one = splats([0.5], half_life=0.1)
    one.motion[:] = 0  # visible to all cameras

    def everywhere(value: object) -> list[np.ndarray]:
        return [np.full((24, 32), value) for _ in cameras]

    def ghost(moment: float, moving: bool, error: float) -> bool:
        return bool(visible_where_still(one, cameras, moment, everywhere(moving), everywhere(np.float32(error)))[0])

    assert ghost(0.5, moving=False, error=30)
    assert not ghost(0.5, moving=True, error=30)
    assert not ghost(0.5, moving=False, error=5)
    assert not ghost(0.9, moving=False, error=30)  # it is not visible then
