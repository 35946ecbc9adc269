"""The Triton step of RMSprop against torch's Adam without first moments."""

from __future__ import annotations

import pytest
import torch

from hgs_core.train import rmsprop
from tests.interpreted_triton import DEVICE


@pytest.fixture(autouse=True)
def triton_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rmsprop, "available", lambda like: True)
    monkeypatch.setattr(rmsprop.library, "available", lambda: False)


@pytest.mark.parametrize(
    ("shape", "rates"), [((7,), None), ((350, 4, 3), None), ((7,), (7,)), ((350, 4, 3), (350, 4, 1))]
)
def test_steps_are_those_of_torch(shape: tuple[int, ...], rates: tuple[int, ...] | None) -> None:
    generator = torch.Generator().manual_seed(0)
    parameter = torch.randn(shape, generator=generator).to(DEVICE)
    factors = None if rates is None else torch.rand(rates, generator=generator).to(DEVICE)
    start = parameter.double()
    moments = torch.zeros_like(parameter)
    peer = torch.nn.Parameter(parameter.double())
    truth = torch.optim.Adam([peer], lr=0.01, betas=(0.0, 0.999), eps=1e-15)
    for step in range(1, 6):
        gradient = torch.randn(shape, generator=generator).to(DEVICE)
        peer.grad = gradient.double()
        truth.step()
        rmsprop.rmsprop_update(parameter, gradient, moments, 0.01 if factors is None else 0.01 * factors, step)
    moved = (peer.detach() - start) * (1.0 if factors is None else factors.double())
    torch.testing.assert_close(parameter.double(), start + moved, rtol=1e-5, atol=1e-6)


def test_rows_that_are_not_shown_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    generator = torch.Generator().manual_seed(1)
    start = torch.randn((350, 4, 3), generator=generator).to(DEVICE)
    rows = torch.randperm(350, generator=generator)[:90].sort().values.to(DEVICE)
    gradient = torch.randn((90, 4, 3), generator=generator).to(DEVICE)
    decays, rates = (
        torch.rand(90, generator=generator).to(DEVICE),
        torch.rand((90, 1, 1), generator=generator).to(DEVICE),
    )
    results = []
    for by_triton in (True, False):
        monkeypatch.setattr(rmsprop, "available", lambda like, found=by_triton: found)
        parameter, moments = start.clone(), start.abs()
        rmsprop.rmsprop_update(parameter, gradient, moments, 0.1 * rates, 3, rows=rows, decays=decays)
        results.append((parameter, moments))
    torch.testing.assert_close(results[0], results[1])
    others = torch.ones(350, dtype=torch.bool)
    others[rows.cpu()] = False
    assert torch.equal(results[0][0].cpu()[others], start.cpu()[others])
