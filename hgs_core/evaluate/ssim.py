"""Structural similarity (Wang, Bovik, Sheikh and Simoncelli, 2004)."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import conv2d

from hgs_core.native import library
from hgs_core.native.loss import l1_dssim

__all__ = ["gaussian_window", "ssim", "ssim_map"]

C1, C2 = 0.01**2, 0.03**2  # for a data range of 1


def ssim(image: Tensor, truth: Tensor) -> float:
    """Return the mean structural similarity of two pictures [3, H, W] in [0, 1]; data range 1.

    Float32 pictures on the CPU use the compiled kernel of the loss where there is one: it is much faster.
    """
    if image.device.type == "cpu" and image.dtype == torch.float32 and library.available():
        return 1 - l1_dssim(image.contiguous().numpy(), truth.contiguous().numpy(), dssim_weight=1.0)[0]
    return float(ssim_map(image, truth).mean())


def gaussian_window(dtype: torch.dtype, device: torch.device | str = "cpu") -> Tensor:
    """The normalised 11-tap Gaussian of standard deviation 1.5 pixels, [11]."""
    x = torch.arange(-5, 6, dtype=dtype, device=device)
    weights = torch.exp(-x * x / (2 * 1.5**2))
    return weights / weights.sum()


def ssim_map(x: Tensor, y: Tensor) -> Tensor:
    """Structural similarity of pictures [C, H, W] at every pixel and channel, zero padding, data range 1.

    Wang, Bovik, Sheikh and Simoncelli, 2004, equation 13.
    """
    window = gaussian_window(x.dtype, x.device)

    def blur(picture: Tensor) -> Tensor:
        across = conv2d(picture[:, None], window.view(1, 1, 1, 11), padding=(0, 5))
        return conv2d(across, window.view(1, 1, 11, 1), padding=(5, 0))[:, 0]

    mx, my = blur(x), blur(y)
    vx, vy, vxy = blur(x * x) - mx * mx, blur(y * y) - my * my, blur(x * y) - mx * my
    return (2 * mx * my + C1) * (2 * vxy + C2) / ((mx * mx + my * my + C1) * (vx + vy + C2))
