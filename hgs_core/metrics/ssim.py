"""Structural similarity (Wang, Bovik, Sheikh and Simoncelli, 2004)."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor
from torch.nn.functional import conv2d, pad

from hgs_core.native import library
from hgs_core.native.ssim import mean_ssim

__all__ = ["RADIUS", "gaussian_window", "region_ssim", "ssim", "ssim_map", "ssim_terms"]

C1, C2 = 0.01**2, 0.03**2  # data range 1
RADIUS = 5  # radius of the window, pixels


def ssim(image: Tensor, truth: Tensor) -> float:
    """Return the mean structural similarity of two pictures [3, H, W] in [0, 1]; data range 1.

    Float32 pictures on the CPU use the compiled kernel where there is one: it is much faster.
    """
    if image.device.type == "cpu" and image.dtype == torch.float32 and library.available():
        return mean_ssim(image.contiguous().numpy(), truth.contiguous().numpy())
    return float(ssim_map(image, truth).mean())


def region_ssim(image: Tensor, truth: Tensor, region: Tensor) -> float | None:
    """Return the mean of the similarity map over the pixels `region` [H, W] of a picture; None if there are none.

    Windows reach five pixels beyond the region. Nothing farther away is computed.
    """
    if not region.any():
        return None
    rows, columns = _reached(region.any(1)), _reached(region.any(0))
    inside = region[rows, columns]
    total = 0.0
    for x, y in zip(image[:, rows, columns], truth[:, rows, columns], strict=True):  # planes of little memory
        luminance, contrast_structure = ssim_terms(x[None], y[None], _shifted_means)
        total += float((luminance * contrast_structure)[0][inside].double().sum())
    return total / (len(image) * int(inside.sum()))


def gaussian_window(dtype: torch.dtype, device: torch.device | str = "cpu") -> Tensor:
    """The normalised 11-tap Gaussian of standard deviation 1.5 pixels, [11]."""
    x = torch.arange(-RADIUS, RADIUS + 1, dtype=dtype, device=device)
    weights = torch.exp(-x * x / (2 * 1.5**2))
    return weights / weights.sum()


def ssim_map(x: Tensor, y: Tensor) -> Tensor:
    """Structural similarity of pictures [C, H, W] at every pixel and channel, zero padding, data range 1.

    Wang, Bovik, Sheikh and Simoncelli, 2004, equation 13.
    """
    window = gaussian_window(x.dtype, x.device)

    def blur(planes: Tensor) -> Tensor:
        across = conv2d(planes[:, None], window.view(1, 1, 1, -1), padding=(0, RADIUS))
        return conv2d(across, window.view(1, 1, -1, 1), padding=(RADIUS, 0))[:, 0]

    luminance, contrast_structure = ssim_terms(x, y, blur)
    return luminance * contrast_structure


def ssim_terms(x: Tensor, y: Tensor, blur: Callable[[Tensor], Tensor]) -> tuple[Tensor, Tensor]:
    """The two factors of SSIM for pictures [C, H, W], data range 1; `blur` takes local means of planes.

    Returns:
        luminance (2 mx my + C1) / (mx^2 + my^2 + C1), and contrast times structure (2 vxy + C2) / (vx + vy + C2).
    """
    mx, my, squares, product = blur(x), blur(y), blur(x * x + y * y), blur(x * y)
    mx2_my2, mxmy = mx * mx + my * my, mx * my
    return (2 * mxmy + C1) / (mx2_my2 + C1), (2 * (product - mxmy) + C2) / (squares - mx2_my2 + C2)


def _reached(marked: Tensor) -> slice:
    """Return the span of the marked places [N] and of the windows around them."""
    places = marked.nonzero()
    return slice(max(0, int(places[0]) - RADIUS), int(places[-1]) + RADIUS + 1)


def _shifted_means(planes: Tensor) -> Tensor:
    """Return the local means of planes [N, H, W], zero padding, as weighted sums of shifted planes."""
    weights = gaussian_window(planes.dtype, planes.device).tolist()
    for dim, padding in ((1, (0, 0, RADIUS, RADIUS)), (2, (RADIUS, RADIUS))):
        length, wide = planes.shape[dim], pad(planes, padding)
        planes = wide.narrow(dim, 0, length) * weights[0]
        for shift, weight in enumerate(weights[1:], 1):
            planes.add_(wide.narrow(dim, shift, length), alpha=weight)
    return planes
