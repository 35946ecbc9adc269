"""The training loss on tensors of the device that the Triton kernels run on."""

from __future__ import annotations

import torch
import triton
from torch import Tensor

from hgs_core.render.triton.device import launching_on
from hgs_core.train.triton.kernels.loss import blur_derivatives, blur_pictures, differentiate_ssim, write_gradient

__all__ = ["l1_dssim"]

_BLOCK = 256


def l1_dssim(image: Tensor, target: Tensor, dssim_weight: float) -> tuple[Tensor, Tensor]:
    """Compare two pictures by `(1 - w) mean |x - y| + w (1 - SSIM(x, y))` (docs/numerics.md, "Loss").

    SSIM is the mean over the windows around every second pixel of every third row.

    Args:
        image: [3, H, W] float32 planes, data range 1, contiguous.
        target: [3, H, W], the same.
        dssim_weight: w above.

    Returns:
        The loss, a scalar, and its gradient with respect to `image`, [3, H, W]; the same bits every time.
    """
    _, height, width = image.shape
    values, windows = image.numel(), 3 * ((width + 1) // 2) * ((height + 2) // 3)
    grid = (triton.cdiv(values, _BLOCK),)
    blurs = torch.empty((4, *image.shape), device=image.device)
    derivatives = torch.empty((3, *image.shape), device=image.device)
    gradient = torch.empty_like(image)
    ssim, l1 = torch.empty((2, *grid), device=image.device)
    with launching_on(image.device):
        blur_pictures[grid](image, target, blurs, width, height, BLOCK=_BLOCK)
        differentiate_ssim[grid](blurs, derivatives, ssim, width, height, -dssim_weight / windows, BLOCK=_BLOCK)
        blur_derivatives[grid](derivatives, blurs, width, height, BLOCK=_BLOCK)
        write_gradient[grid](
            image, target, blurs, gradient, l1, width, height, (1 - dssim_weight) / values, BLOCK=_BLOCK
        )
    mean_l1, mean_ssim = l1.sum(dtype=torch.float64) / values, ssim.sum(dtype=torch.float64) / windows
    return ((1 - dssim_weight) * mean_l1 + dssim_weight * (1 - mean_ssim)).float(), gradient
