"""The equations of time in torch against those on numpy arrays, which know nothing of each other."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.render.moment import alive, moment_of_dynamic, moment_of_static
from hgs_core.scene.temporal import evaluate, lifetime
from tests.hgs_core.render.scenes import dynamic_splats, static_splats

TIMES = (0.0, 0.4, 1.0)


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("coefficients", [4, 6])
def test_dynamic_splats_are_where_their_polynomials_say(time: float, coefficients: int) -> None:
    splats = dynamic_splats(50, coefficients=coefficients)
    moment = moment_of_dynamic(splats, time)
    positions, quats, opacities = evaluate(splats.map(torch.Tensor.numpy), time)
    np.testing.assert_allclose(moment.means.numpy(), positions, rtol=1e-12)
    unit = moment.quats / moment.quats.norm(dim=1, keepdim=True)
    np.testing.assert_allclose(unit.numpy(), quats, atol=1e-12)
    np.testing.assert_allclose(moment.opacities.numpy(), opacities, rtol=1e-12)
    assert torch.equal(moment.rgb, splats.rgb)
    assert torch.equal(moment.log_scales, splats.log_scales)


@pytest.mark.parametrize("time", TIMES)
def test_alive_are_those_whose_lifetime_holds_the_moment(time: float) -> None:
    splats = dynamic_splats(200)
    start, end = lifetime(splats.map(torch.Tensor.numpy))
    living = alive(splats, time).numpy()
    np.testing.assert_array_equal(living, (start <= time) & (time <= end))
    assert 0 < living.sum() < 200


def test_a_precision_beyond_all_numbers_is_one_instant() -> None:
    splats = dynamic_splats(2)
    splats.time_log_precisions[:] = 1e4
    splats.time_centers[:] = torch.tensor([0.5, 0.25])
    splats.opacity_logits[:] = 2.0
    assert alive(splats, 0.5).tolist() == [True, False]
    assert torch.isfinite(moment_of_dynamic(splats, 0.5).opacities).all()


def test_float32_splats_are_evaluated_in_float64() -> None:
    splats = dynamic_splats(3, dtype=torch.float32)
    splats.motion[:, 0] += 1e5  # far from the origin float32 has steps of 1/128
    expected, _, _ = evaluate(splats.map(torch.Tensor.numpy), 0.37)
    np.testing.assert_allclose(moment_of_dynamic(splats, 0.37).means.numpy(), expected, rtol=1e-14)


def test_static_splats_are_as_they_always_are() -> None:
    splats = static_splats(5, dtype=torch.float32)
    moment = moment_of_static(splats)
    assert all(array.dtype == torch.float64 for array in vars(moment).values())
    assert torch.equal(moment.means, splats.means.double())
    np.testing.assert_allclose(moment.opacities.numpy(), 1 / (1 + np.exp(-splats.opacity_logits.double().numpy())))


def test_gradients_of_a_moment_reach_the_parameters() -> None:
    splats = dynamic_splats(3).map(lambda array: array.requires_grad_())
    moment = moment_of_dynamic(splats, 0.7)
    sum(array.sum() for array in vars(moment).values()).backward()
    offsets = (0.7 - splats.time_centers.detach())[:, None]
    assert splats.motion.grad is not None
    for k in range(4):  # d means / d coefficient k is the offset to the power of k
        torch.testing.assert_close(splats.motion.grad[:, k], (offsets**k).expand(3, 3))
