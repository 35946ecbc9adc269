"""Peak signal-to-noise ratio."""

from __future__ import annotations

import math

from torch import Tensor

__all__ = ["decibels", "psnr"]


def psnr(image: Tensor, truth: Tensor) -> float:
    """Return the PSNR in dB of two pictures of equal shape in [0, 1], peak 1; infinite if they are equal."""
    return decibels(float((image - truth).double().square().mean()))


def decibels(squared_error: float) -> float:
    """Return the PSNR in dB of a mean squared error, peak 1; infinite for 0."""
    return -10 * math.log10(squared_error) if squared_error > 0 else math.inf
