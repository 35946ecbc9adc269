"""The Triton step of Adam against torch.optim.Adam."""

from __future__ import annotations

import pytest
import torch

from hgs_core.train import adam
from tests.interpreted_triton import DEVICE


@pytest.mark.parametrize(
    ("shape", "rates"), [((7,), None), ((350, 4, 3), None), ((7,), (7,)), ((350, 4, 3), (350, 4, 1))]
)
def test_steps_are_those_of_torch(
    shape: tuple[int, ...], rates: tuple[int, ...] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(adam, "available", lambda like: True)
    monkeypatch.setattr(adam.library, "available", lambda: False)
    generator = torch.Generator().manual_seed(0)
    parameter = torch.randn(shape, generator=generator).to(DEVICE)
    factors = None if rates is None else torch.rand(rates, generator=generator).to(DEVICE)
    start = parameter.double()
    first, second = torch.zeros_like(parameter), torch.zeros_like(parameter)
    peer = torch.nn.Parameter(parameter.double())
    truth = torch.optim.Adam([peer], lr=0.01, betas=(0.9, 0.999), eps=1e-15)
    for step in range(1, 6):
        gradient = torch.randn(shape, generator=generator).to(DEVICE)
        peer.grad = gradient.double()
        truth.step()
        adam.adam_update(parameter, gradient, first, second, 0.01 if factors is None else 0.01 * factors, step)
    moved = (peer.detach() - start) * (1.0 if factors is None else factors.double())
    torch.testing.assert_close(parameter.double(), start + moved, rtol=1e-5, atol=1e-6)
