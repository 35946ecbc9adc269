"""The trainer's loss against torch convolutions in float64."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.native import library
from hgs_core.train import loss
from tests.hgs_core.native.test_loss import pictures, reference
from tests.tolerances import assert_close


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("weight", [0.0, 0.2, 1.0])
def test_value_and_gradient(compiled: bool, weight: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the compiled kernel, and in torch where that is missing."""
    if compiled and not library.available():
        pytest.skip("the compiled library is not there")
    if not compiled:
        monkeypatch.setattr(loss.library, "available", lambda: False)
    image, target = pictures(29, 23)
    drawn = torch.from_numpy(image).requires_grad_()
    value = 2 * loss.photometric_loss(drawn, torch.from_numpy(target), weight)
    value.backward()  # type: ignore[no-untyped-call]
    true_value, true_gradient = reference(image, target, weight)
    assert drawn.grad is not None
    assert_close(np.float32(value.detach()), 2 * np.float64(true_value), "loss")
    assert_close(drawn.grad.numpy(), 2 * np.asarray(true_gradient), "gradient")


def test_float64_keeps_its_digits() -> None:
    image, target = (torch.from_numpy(picture).double() for picture in pictures(29, 23))
    value = loss.photometric_loss(image, target, 0.2)
    assert value.dtype == torch.float64
    true_value, _ = reference(image.numpy(), target.numpy(), 0.2)
    assert float(value) == pytest.approx(float(true_value), rel=1e-6)


@pytest.mark.parametrize("compiled", [True, False])
def test_the_gradient_alone_is_that_of_the_value(compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not compiled:
        monkeypatch.setattr(loss.library, "available", lambda: False)
    image, target = (torch.from_numpy(picture) for picture in pictures(29, 23))
    drawn = image.clone().requires_grad_()
    loss.photometric_loss(drawn, target, 0.2).backward()  # type: ignore[no-untyped-call]
    found = loss.photometric_gradient(image, target, 0.2)
    assert not found.requires_grad
    assert drawn.grad is not None
    assert torch.equal(found, drawn.grad)
