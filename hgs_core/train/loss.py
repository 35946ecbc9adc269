"""The training loss: L1 and structural dissimilarity (docs/numerics.md, "Loss")."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from hgs_core.metrics.ssim import ssim_map
from hgs_core.native import library
from hgs_core.native.loss import l1_dssim
from hgs_core.render.triton.device import available

__all__ = ["photometric_gradient", "photometric_loss"]


def photometric_loss(image: Tensor, target: Tensor, dssim: float) -> Tensor:
    """Return (1 - dssim) mean|image - target| + dssim (1 - SSIM) of two pictures [3, H, W] in [0, 1].

    SSIM is the mean over the windows around every second pixel of every third row (docs/numerics.md, "Loss").
    Float32 pictures on the CPU use the compiled kernel where there is one, those on a CUDA device the Triton kernels.
    """
    if image.device.type == "cpu" and image.dtype == torch.float32 and library.available():
        return _NativeLoss.apply(image, target, dssim)  # type: ignore[no-any-return,no-untyped-call]
    if available(image):
        return _TritonLoss.apply(image, target, dssim)  # type: ignore[no-any-return,no-untyped-call]
    similarity = ssim_map(image, target)[:, ::3, ::2].mean()
    return (1 - dssim) * (image - target).abs().mean() + dssim * (1 - similarity)


def photometric_gradient(image: Tensor, target: Tensor, dssim: float) -> Tensor:
    """Return the gradient [3, H, W] of `photometric_loss` towards `image`; neither picture takes part in autograd."""
    if image.device.type == "cpu" and image.dtype == torch.float32 and library.available():
        _, gradient = l1_dssim(image.contiguous().numpy(), target.contiguous().numpy(), dssim_weight=dssim)
        return torch.from_numpy(gradient)
    own = image.clone().requires_grad_(True)
    (found,) = torch.autograd.grad(photometric_loss(own, target, dssim), own)
    return found


class _NativeLoss(torch.autograd.Function):
    """The compiled loss; its gradient is computed together with its value."""

    @staticmethod
    def forward(ctx: Any, image: Tensor, target: Tensor, dssim: float) -> Tensor:
        value, gradient = l1_dssim(image.detach().contiguous().numpy(), target.contiguous().numpy(), dssim_weight=dssim)
        ctx.gradient = torch.from_numpy(gradient)
        return torch.tensor(value, dtype=torch.float32)

    @staticmethod
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, None, None]:
        # By itself, where the loss is what is differentiated: a pass over the picture less.
        return ctx.gradient if float(upstream) == 1 else ctx.gradient * upstream, None, None


class _TritonLoss(torch.autograd.Function):
    """The same on a CUDA device."""

    @staticmethod
    def forward(ctx: Any, image: Tensor, target: Tensor, dssim: float) -> Tensor:
        from hgs_core.train.triton.loss import l1_dssim

        value, ctx.gradient = l1_dssim(image.detach().contiguous(), target.contiguous(), dssim)
        return value

    @staticmethod
    def backward(ctx: Any, upstream: Tensor) -> tuple[Tensor, None, None]:
        return ctx.gradient * upstream, None, None
