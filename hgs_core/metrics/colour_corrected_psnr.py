"""PSNR after the best affine colour map of each camera: what is left when white balance and exposure are forgiven.

Training can learn how its own cameras see colours, but not how a camera does that it has never seen. Where the cameras
of a capture disagree, the plain PSNR of a held-out one measures its white balance as much as the scene.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hgs_core.metrics.psnr import decibels

__all__ = ["ColourCorrectedError", "colour_corrected_psnr"]


class ColourCorrectedError:
    """The squared error of one camera's pictures after the affine map of colours that makes it least.

    The map A rgb + b is the same for all frames. Only the sums of the normal equations are kept, in float64, and the
    error follows from them: mapped colours are not clamped.
    """

    def __init__(self) -> None:
        self._gram = torch.zeros(4, 4, dtype=torch.float64)  # of (r, g, b, 1) of the pictures
        self._cross = torch.zeros(4, 3, dtype=torch.float64)  # of these with the truth
        self._truth = 0.0  # sum of squares of the truth
        self._values = 0  # colour values

    def add(self, image: Tensor, truth: Tensor) -> None:
        """Add a frame and its truth, [3, H, W] in [0, 1]."""
        pixels, target = image.flatten(1).double(), truth.flatten(1).double()
        extended = torch.cat([pixels, torch.ones_like(pixels[:1])])
        self._gram += extended @ extended.T
        self._cross += extended @ target.T
        self._truth += float(target.square().sum())
        self._values += target.numel()

    def psnr(self) -> float:
        """Return the PSNR in dB of the squared error pooled over all frames, peak 1; nan without frames."""
        if self._values == 0:
            return math.nan
        explained = self._cross * (torch.linalg.pinv(self._gram, hermitian=True) @ self._cross)
        return decibels(max(0.0, self._truth - float(explained.sum())) / self._values)


def colour_corrected_psnr(images: Tensor, truths: Tensor) -> float:
    """Return the PSNR in dB of one camera's frames [F, 3, H, W] after the affine map of colours that fits them best."""
    error = ColourCorrectedError()
    for image, truth in zip(images, truths, strict=True):
        error.add(image, truth)
    return error.psnr()
