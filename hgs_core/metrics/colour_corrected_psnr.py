"""PSNR after the best affine colour map of each camera, which forgives white balance and exposure.

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

    The map A rgb + b is the same for all frames and fitted to whole pictures; its error can also be told for a region
    of them. Only sums of products are kept, in float64, and errors follow from them: mapped colours are not clamped.
    """

    def __init__(self) -> None:
        self._whole, self._region = _Products(), _Products()

    def add(self, image: Tensor, truth: Tensor, region: Tensor | None = None) -> None:
        """Add a frame and its truth, [3, H, W] in [0, 1], and the pixels [H, W] of its region (None: it has none)."""
        self._whole.add(image.flatten(1), truth.flatten(1))
        if region is not None:
            self._region.add(image[:, region], truth[:, region])

    def include(self, other: ColourCorrectedError) -> None:
        """Add all frames of another."""
        self._whole.include(other._whole)
        self._region.include(other._region)

    def psnr(self) -> float:
        """Return the PSNR in dB of the squared error pooled over all frames, peak 1; nan without frames."""
        if self._whole.values == 0:
            return math.nan
        return decibels(self._whole.squared_error(self._map()) / self._whole.values)

    def region_error(self) -> tuple[float, int]:
        """Return the squared error of the regions, added up over all frames, and of how many values it is."""
        return self._region.squared_error(self._map()), self._region.values

    def _map(self) -> Tensor:
        """Return the best map [4, 3]."""
        inverse: Tensor = torch.linalg.pinv(self._whole.gram, hermitian=True)
        return inverse @ self._whole.cross


class _Products:
    """Sums over pixels of the products of drawn colours with themselves and with the true ones."""

    def __init__(self) -> None:
        self.gram = torch.zeros(4, 4, dtype=torch.float64)  # sums of products of the pictures' (r, g, b, 1)
        self.cross = torch.zeros(4, 3, dtype=torch.float64)  # sums of products with the truth
        self.truth = 0.0  # sum of squares of the truth
        self.values = 0  # colour values

    def add(self, pixels: Tensor, target: Tensor) -> None:
        """Add pixels [3, N] and their truth."""
        pixels, target = pixels.double(), target.double()
        extended = torch.cat([pixels, torch.ones_like(pixels[:1])])
        self.gram += extended @ extended.T
        self.cross += extended @ target.T
        self.truth += float(target.square().sum())
        self.values += target.numel()

    def include(self, other: _Products) -> None:
        """Add the sums of another."""
        self.gram += other.gram
        self.cross += other.cross
        self.truth += other.truth
        self.values += other.values

    def squared_error(self, affine: Tensor) -> float:
        """Return the sum of squares that a map [4, 3] leaves: of `affine^T x - y` over all pixels."""
        explained = (affine * (2 * self.cross - self.gram @ affine)).sum()
        return max(0.0, self.truth - float(explained))


def colour_corrected_psnr(images: Tensor, truths: Tensor) -> float:
    """Return the PSNR in dB of one camera's frames [F, 3, H, W] after the affine map of colours that fits them best."""
    error = ColourCorrectedError()
    for image, truth in zip(images, truths, strict=True):
        error.add(image, truth)
    return error.psnr()
