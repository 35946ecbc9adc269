"""The Triton loss against torch convolutions in float64, by way of the trainer's own function."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.train import loss
from tests.hgs_core.native.test_loss import pictures, reference
from tests.interpreted_triton import DEVICE
from tests.tolerances import assert_close


# Narrower than the window; one pixel; no multiple of a block.
@pytest.mark.parametrize(
    ("width", "height", "weight"), [(3, 4, 0.2), (1, 1, 0.2), (29, 13, 0.0), (29, 13, 0.2), (13, 29, 1.0)]
)
def test_value_and_gradient(width: int, height: int, weight: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loss, "available", lambda like: True)
    monkeypatch.setattr(loss.library, "available", lambda: False)
    image, target = pictures(width, height)
    drawn = torch.from_numpy(image).to(DEVICE).requires_grad_()
    value = loss.photometric_loss(drawn, torch.from_numpy(target).to(DEVICE), weight)
    value.backward()  # type: ignore[no-untyped-call]
    true_value, true_gradient = reference(image, target, weight)
    assert drawn.grad is not None
    assert_close(np.float32(value.detach().cpu()), true_value, "loss")
    assert_close(drawn.grad.cpu().numpy(), true_gradient, "gradient")
