"""Fused Adam against torch.optim.Adam in float64."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.native.adam import adam_step
from tests.tolerances import assert_close


def test_ten_steps_are_those_of_torch() -> None:
    r = np.random.default_rng(0)
    start = r.normal(size=(5001, 3)).astype(np.float32)  # more than one block, and not a multiple of a vector
    parameters, first, second = start.copy(), np.zeros_like(start), np.zeros_like(start)
    truth = torch.nn.Parameter(torch.tensor(start, dtype=torch.float64))
    optimiser = torch.optim.Adam([truth], lr=0.01, betas=(0.9, 0.999), eps=1e-8)
    for step in range(1, 11):
        gradients = (r.normal(size=start.shape) * 10 ** r.uniform(-3, 3, start.shape)).astype(np.float32)
        adam_step(parameters, gradients, first, second, 0.01, step, epsilon=1e-8)
        truth.grad = torch.tensor(gradients, dtype=torch.float64)
        optimiser.step()
    state = optimiser.state[truth]
    assert_close(parameters, truth.detach().numpy(), "parameters")
    assert_close(first, state["exp_avg"].numpy(), "first moments")
    assert_close(second, state["exp_avg_sq"].numpy(), "second moments")


@pytest.mark.parametrize("shape", [(5001, 1, 1), (5001, 3, 1), (5001, 3, 4)])
def test_a_factor_counts_for_all_values_of_its_row(shape: tuple[int, ...]) -> None:
    r = np.random.default_rng(2)
    gradients = r.normal(size=(5001, 3, 4)).astype(np.float32)
    factors = r.uniform(0, 2, shape).astype(np.float32)
    plain, scaled = np.zeros_like(gradients), np.zeros_like(gradients)
    for parameters, given in ((plain, None), (scaled, factors.ravel())):
        first, second = np.zeros_like(gradients), np.zeros_like(gradients)
        for step in (1, 2):
            adam_step(parameters, gradients * step, first, second, 0.01, step, factors=given)
    assert_close(scaled, plain.astype(np.float64) * factors, "parameters")


def test_same_bits_for_any_number_of_threads() -> None:
    def run(threads: int) -> bytes:
        r = np.random.default_rng(1)
        arrays = [r.uniform(size=300110).astype(np.float32) for _ in range(4)]
        factors = r.uniform(size=30011).astype(np.float32)
        adam_step(arrays[0], arrays[1], arrays[2], arrays[3], 0.01, 3, threads=threads, factors=factors)
        return b"".join(array.tobytes() for array in arrays)

    assert len({run(threads) for threads in (1, 2, 3, 7)}) == 1


def test_no_values() -> None:
    empty = np.zeros((0, 3), np.float32)
    adam_step(empty, empty, empty, empty, 0.01, 1)


def test_refuses_arrays_it_would_misread() -> None:
    good = np.zeros(4, np.float32)
    with pytest.raises(ValueError, match="gradients must be a contiguous float32 array"):
        adam_step(good, np.zeros(4), good, good, 0.01, 1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="not contiguous"):
        adam_step(good, np.zeros(8, np.float32)[::2], good, good, 0.01, 1)
    with pytest.raises(ValueError, match=r"factors must divide the 4 values, got shape \(3,\)"):
        adam_step(good, good, good, good, 0.01, 1, factors=good[:3])
    with pytest.raises(ValueError, match="step counts from 1"):
        adam_step(good, good, good, good, 0.01, 0)
