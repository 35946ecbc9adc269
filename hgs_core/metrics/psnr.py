"""Peak signal-to-noise ratio."""

from __future__ import annotations

import math

from torch import Tensor

__all__ = ["psnr"]


def psnr(image: Tensor, truth: Tensor) -> float:
    """Return the PSNR in dB of two pictures of equal shape in [0, 1], peak 1; infinite if they are equal."""
    error = float((image - truth).double().square().mean())
    return -10 * math.log10(error) if error > 0 else math.inf
