"""RMSprop against torch's Adam without first moments, and rows that come and go or are not shown."""

from __future__ import annotations

import dataclasses

import pytest
import torch
from torch import Tensor

from hgs_core.native import library
from hgs_core.scene import StaticSplats
from hgs_core.train.rmsprop import RmsProp, rmsprop_update
from tests.hgs_core.render.scenes import static_splats

RATES: dict[str, float | Tensor] = {
    "means": 0.01,
    "log_scales": 0.02,
    "quats": 0.03,
    "opacity_logits": 0.04,
    "rgb": 0.05,
}


@pytest.fixture(params=["compiled", "torch"])
def kernels(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "torch":
        monkeypatch.setattr(library, "available", lambda: False)


def peers_of(splats: StaticSplats[Tensor]) -> tuple[dict[str, torch.nn.Parameter], torch.optim.Adam]:
    peers = {name: torch.nn.Parameter(array.double()) for name, array in splats.items()}
    groups = [{"params": [peer], "lr": RATES[name]} for name, peer in peers.items()]
    return peers, torch.optim.Adam(groups, betas=(0.0, 0.999), eps=1e-15)


@pytest.mark.usefixtures("kernels")
def test_steps_are_those_of_torch() -> None:
    splats = static_splats(7, dtype=torch.float32)
    peers, truth = peers_of(splats)
    optimiser = RmsProp.of(splats)
    generator = torch.Generator().manual_seed(0)
    for _ in range(5):
        for name, array in splats.items():
            array.grad = torch.randn(array.shape, generator=generator)
            peers[name].grad = array.grad.double()
        truth.step()
        optimiser.step(splats, RATES)
    for name, array in splats.items():
        torch.testing.assert_close(array.double(), peers[name].detach(), rtol=1e-5, atol=1e-6)


@pytest.mark.usefixtures("kernels")
def test_splats_that_a_step_does_not_show_are_as_if_their_gradient_had_been_zero() -> None:
    splats = static_splats(9, dtype=torch.float32)
    peers, truth = peers_of(splats)
    optimiser = RmsProp.of(splats)
    generator = torch.Generator().manual_seed(1)
    for step in range(12):
        rows = torch.randperm(9, generator=generator)[:4].sort().values
        everything = step in (5, 11)
        shown = splats if everything else splats.map(lambda array, rows=rows: array[rows].clone())
        for name, array in shown.items():
            array.grad = torch.randn(array.shape, generator=generator)
            peers[name].grad = torch.zeros_like(peers[name])
            peers[name].grad[slice(None) if everything else rows] = array.grad.double()
        truth.step()
        optimiser.step(splats, RATES) if everything else optimiser.step(splats, RATES, shown, rows)
    for name, array in splats.items():
        torch.testing.assert_close(array.double(), peers[name].detach(), rtol=1e-4, atol=1e-5)


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("shape", [(3, 1, 1), (3, 2, 1), (3, 2, 4)])
def test_rates_count_for_the_rows_they_stand_for(shape: tuple[int, ...]) -> None:
    generator = torch.Generator().manual_seed(1)
    gradient, rates = torch.randn(3, 2, 4, generator=generator), torch.rand(shape, generator=generator)
    moved = []
    for rate in (1.0, rates):
        parameter, moments = (torch.zeros(3, 2, 4) for _ in range(2))
        for step in (1, 2):
            rmsprop_update(parameter, step * gradient, moments, rate, step)
        moved.append(parameter)
    torch.testing.assert_close(moved[1], moved[0] * rates)


def test_rates_for_columns_are_refused() -> None:
    arrays = [torch.zeros(3, 2) for _ in range(3)]
    for shape in [(2,), (1, 2), (3,), (2, 1)]:
        with pytest.raises(ValueError, match=r"are not for rows of \(3, 2\)"):
            rmsprop_update(*arrays, torch.ones(shape), 1)
    with pytest.raises(ValueError, match="step counts from 1"):
        rmsprop_update(*arrays, 0.01, 0)


def test_arrays_without_a_gradient_stay() -> None:
    splats = static_splats(3, dtype=torch.float32)
    before = splats.rgb.clone()
    splats.means.grad = torch.ones_like(splats.means)
    RmsProp.of(splats).step(splats, RATES)
    assert torch.equal(splats.rgb, before)


def test_selection_keeps_rows_and_appends_zeros() -> None:
    splats = static_splats(4, dtype=torch.float32)
    optimiser = RmsProp.of(splats)
    optimiser.moments.rgb[:] = torch.arange(4.0)[:, None]
    optimiser.updated[:] = torch.tensor([4, 5, 6, 7])
    optimiser.steps = 8
    optimiser.select(torch.tensor([3, 1]), added=2)
    assert optimiser.moments.rgb[:, 0].tolist() == [3, 1, 0, 0]
    assert optimiser.updated.tolist() == [7, 5, 8, 8]
    assert [f.name for f in dataclasses.fields(StaticSplats)] == [name for name, _ in optimiser.moments.items()]
