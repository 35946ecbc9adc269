"""The fused loss against torch convolutions in float64, written down independently."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.native.loss import l1_dssim
from tests.tolerances import assert_close

Picture = npt.NDArray[np.float32]


def pictures(width: int, height: int, seed: int = 0) -> tuple[Picture, Picture]:
    r = np.random.default_rng(seed)
    target = r.uniform(size=(3, height, width)).astype(np.float32)
    image = np.clip(target + r.normal(0, 0.2, target.shape), -0.1, 1.2).astype(np.float32)
    return image, target


def reference(image: Picture, target: Picture, weight: float) -> tuple[float, npt.NDArray[np.float64]]:
    x = torch.tensor(image, dtype=torch.float64, requires_grad=True)
    y = torch.tensor(target, dtype=torch.float64)
    taps = torch.exp(-((torch.arange(11, dtype=torch.float64) - 5) ** 2) / (2 * 1.5**2))
    window = torch.outer(taps, taps)[None, None] / taps.sum() ** 2

    def blur(planes: torch.Tensor) -> torch.Tensor:
        return torch.nn.functional.conv2d(planes[:, None], window, padding=5)[:, 0]

    mx, my = blur(x), blur(y)
    vx, vy, cxy = blur(x * x) - mx**2, blur(y * y) - my**2, blur(x * y) - mx * my
    ssim = (2 * mx * my + 1e-4) * (2 * cxy + 9e-4) / ((mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4))
    loss = (1 - weight) * (x - y).abs().mean() + weight * (1 - ssim[:, ::3, ::2].mean())
    loss.backward()
    assert x.grad is not None
    return loss.item(), x.grad.numpy()


# Narrower than the window; one pixel; no multiple of a vector; more rows than a band.
@pytest.mark.parametrize(
    ("width", "height"), [(40, 24), (3, 4), (1, 1), (2, 1), (37, 211), (64, 96), (65, 67), (47, 5)]
)
@pytest.mark.parametrize("weight", [0.0, 0.2, 1.0])
def test_value_and_gradient(width: int, height: int, weight: float) -> None:
    image, target = pictures(width, height)
    loss, gradient = l1_dssim(image, target, weight)
    true_loss, true_gradient = reference(image, target, weight)
    assert_close(np.float32(loss), true_loss, "loss")
    assert_close(gradient, true_gradient, "gradient")


def test_equal_pictures_have_no_loss_and_no_gradient() -> None:
    _, target = pictures(50, 30)
    loss, gradient = l1_dssim(target, target)
    assert abs(loss) < 1e-6
    assert np.abs(gradient).max() < 1e-7


def test_same_bits_for_any_number_of_threads() -> None:
    image, target = pictures(75, 300)
    results = {
        (loss, gradient.tobytes()) for loss, gradient in (l1_dssim(image, target, threads=n) for n in (1, 2, 3, 7))
    }
    assert len(results) == 1


def test_refuses_pictures_it_would_misread() -> None:
    image, target = pictures(8, 8)
    with pytest.raises(ValueError, match="target must be a contiguous float32 array of shape"):
        l1_dssim(image, target[:, :4])
    with pytest.raises(ValueError, match="planes"):
        l1_dssim(image[0], target[0])
