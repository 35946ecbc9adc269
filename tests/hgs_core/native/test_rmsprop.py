"""Fused RMSprop against torch's Adam with beta1 = 0 in float64: RMSprop with bias correction."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.native.rmsprop import rmsprop_step
from tests.tolerances import assert_close

BETA = 0.999


def test_ten_steps_are_those_of_torch() -> None:
    r = np.random.default_rng(0)
    start = r.normal(size=(5001, 3)).astype(np.float32)  # more than one block, and not a multiple of a vector
    parameters, moments = start.copy(), np.zeros_like(start)
    truth = torch.nn.Parameter(torch.tensor(start, dtype=torch.float64))
    optimiser = torch.optim.Adam([truth], lr=0.01, betas=(0.0, BETA), eps=1e-8)
    for step in range(1, 11):
        gradients = (r.normal(size=start.shape) * 10 ** r.uniform(-3, 3, start.shape)).astype(np.float32)
        rmsprop_step(parameters, gradients, moments, 0.01, 1 - BETA**step, epsilon=1e-8)
        truth.grad = torch.tensor(gradients, dtype=torch.float64)
        optimiser.step()
    assert_close(parameters, truth.detach().numpy(), "parameters")
    assert_close(moments, optimiser.state[truth]["exp_avg_sq"].numpy(), "second moments")


def test_rows_are_changed_as_if_all_others_had_a_gradient_of_zero() -> None:
    r = np.random.default_rng(3)
    parameters = r.normal(size=(5001, 4)).astype(np.float32)
    moments = np.zeros_like(parameters)
    truth = torch.nn.Parameter(torch.tensor(parameters, dtype=torch.float64))
    optimiser = torch.optim.Adam([truth], lr=0.01, betas=(0.0, BETA), eps=1e-15)
    updated = np.zeros(5001, np.int64)
    for step in range(1, 11):
        rows = np.sort(r.choice(5001, 700, replace=False)) if step < 10 else np.arange(5001)
        gradients = r.normal(size=(len(rows), 4)).astype(np.float32)
        decays = (BETA ** (step - updated[rows])).astype(np.float32)
        rmsprop_step(parameters, gradients, moments, 0.01, 1 - BETA**step, rows=rows, decays=decays)
        updated[rows] = step
        truth.grad = torch.zeros_like(truth)
        truth.grad[rows] = torch.tensor(gradients, dtype=torch.float64)
        optimiser.step()
    assert_close(parameters, truth.detach().numpy(), "parameters")
    assert_close(moments, optimiser.state[truth]["exp_avg_sq"].numpy(), "second moments")


@pytest.mark.parametrize("shape", [(5001, 1, 1), (5001, 3, 1), (5001, 3, 4)])
@pytest.mark.parametrize("listed", [False, True])
def test_a_factor_counts_for_all_values_of_its_row(shape: tuple[int, ...], listed: bool) -> None:
    r = np.random.default_rng(2)
    gradients = r.normal(size=(5001, 3, 4)).astype(np.float32)
    factors = r.uniform(0, 2, shape).astype(np.float32)
    rows = np.arange(5001) if listed else None
    plain, scaled = np.zeros_like(gradients), np.zeros_like(gradients)
    for parameters, given in ((plain, None), (scaled, factors.ravel())):
        moments = np.zeros_like(gradients)
        for step in (1, 2):
            rmsprop_step(parameters, gradients * step, moments, 0.01, 1 - BETA**step, factors=given, rows=rows)
    assert_close(scaled, plain.astype(np.float64) * factors, "parameters")


def test_same_bits_for_any_number_of_threads() -> None:
    def run(threads: int) -> bytes:
        r = np.random.default_rng(1)
        arrays = [r.uniform(size=(30011, 10)).astype(np.float32) for _ in range(3)]
        factors = r.uniform(size=30011).astype(np.float32)
        rmsprop_step(arrays[0], arrays[1], arrays[2], 0.01, 0.003, threads=threads, factors=factors)
        rmsprop_step(arrays[0], arrays[1], arrays[2], 0.01, 0.004, threads=threads)
        return b"".join(array.tobytes() for array in arrays)

    assert len({run(threads) for threads in (1, 2, 3, 7)}) == 1


def test_no_values() -> None:
    empty = np.zeros((0, 3), np.float32)
    rmsprop_step(empty, empty, empty, 0.01, 0.001)
    rmsprop_step(
        np.ones((4, 3), np.float32), empty, np.ones((4, 3), np.float32), 0.01, 0.001, rows=np.zeros(0, np.int64)
    )


def test_refuses_arrays_it_would_misread() -> None:
    good = np.zeros(4, np.float32)
    with pytest.raises(ValueError, match="gradients must be a contiguous float32 array"):
        rmsprop_step(good, np.zeros(4), good, 0.01, 0.001)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="not contiguous"):
        rmsprop_step(good, np.zeros(8, np.float32)[::2], good, 0.01, 0.001)
    with pytest.raises(ValueError, match=r"factors must divide the 4 values, got shape \(3,\)"):
        rmsprop_step(good, good, good, 0.01, 0.001, factors=good[:3])
    with pytest.raises(ValueError, match="rows must be from 0 to 3, got 1 to 4"):
        rmsprop_step(good, good[:2], good, 0.01, 0.001, rows=np.array([1, 4]))
    with pytest.raises(ValueError, match="correction of a step is positive"):
        rmsprop_step(good, good, good, 0.01, 0.0)
