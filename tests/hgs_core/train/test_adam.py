"""Adam against torch.optim.Adam, and rows that come and go."""

from __future__ import annotations

import dataclasses

import pytest
import torch

from hgs_core.native import library
from hgs_core.scene import StaticSplats
from hgs_core.train.adam import Adam, adam_update
from tests.hgs_core.render.scenes import static_splats

RATES = {"means": 0.01, "log_scales": 0.02, "quats": 0.03, "opacity_logits": 0.04, "rgb": 0.05}


def test_steps_are_those_of_torch() -> None:
    splats = static_splats(7, dtype=torch.float32)
    peers = [torch.nn.Parameter(array.clone()) for _, array in splats.items()]
    groups = [{"params": [peer], "lr": rate} for peer, rate in zip(peers, RATES.values(), strict=True)]
    truth = torch.optim.Adam(groups, betas=(0.9, 0.999), eps=1e-15)
    adam = Adam.of(splats)
    generator = torch.Generator().manual_seed(0)
    for _ in range(5):
        for (_, array), peer in zip(splats.items(), peers, strict=True):
            peer.grad = torch.randn(array.shape, generator=generator)
            array.grad = peer.grad.clone()
        truth.step()
        adam.step(splats, RATES)
    for (_, array), peer in zip(splats.items(), peers, strict=True):
        torch.testing.assert_close(array, peer.detach(), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("shape", [(3, 1, 1), (3, 2, 1), (3, 2, 4)])
def test_rates_count_for_the_rows_they_stand_for(
    shape: tuple[int, ...], compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not compiled:
        monkeypatch.setattr(library, "available", lambda: False)
    generator = torch.Generator().manual_seed(1)
    gradient, rates = torch.randn(3, 2, 4, generator=generator), torch.rand(shape, generator=generator)
    moved = []
    for rate in (1.0, rates):
        parameter, first, second = (torch.zeros(3, 2, 4) for _ in range(3))
        for step in (1, 2):
            adam_update(parameter, step * gradient, first, second, rate, step)
        moved.append(parameter)
    torch.testing.assert_close(moved[1], moved[0] * rates)


def test_rates_for_columns_are_refused() -> None:
    arrays = [torch.zeros(3, 2) for _ in range(4)]
    for shape in [(2,), (1, 2), (3,), (2, 1)]:
        with pytest.raises(ValueError, match=r"are not for rows of \(3, 2\)"):
            adam_update(*arrays, torch.ones(shape), 1)


def test_arrays_without_a_gradient_stay() -> None:
    splats = static_splats(3, dtype=torch.float32)
    before = splats.rgb.clone()
    splats.means.grad = torch.ones_like(splats.means)
    Adam.of(splats).step(splats, RATES)
    assert torch.equal(splats.rgb, before)


def test_selection_keeps_rows_and_appends_zeros() -> None:
    splats = static_splats(4, dtype=torch.float32)
    adam = Adam.of(splats)
    adam.second.rgb[:] = torch.arange(4.0)[:, None]
    adam.select(torch.tensor([3, 1]), added=2)
    assert adam.second.rgb[:, 0].tolist() == [3, 1, 0, 0]
    assert [f.name for f in dataclasses.fields(StaticSplats)] == [name for name, _ in adam.first.items()]
