"""PSNR of a region: of the pixels that move, or of those that do not.

Frames are combined in one of two ways, which differ where the region changes its size or the error its strength:

- pooled: the PSNR of the mean squared error over the pixels of all frames. This is what `hgs eval` reports.
- mean of dB: the mean over frames of each frame's PSNR, as is usual for whole pictures. A frame with three moving
  pixels counts as much as one with thousands.
"""

from __future__ import annotations

from collections.abc import Iterable

from torch import Tensor

from hgs_core.metrics.psnr import decibels

__all__ = ["RegionError", "mean_region_psnr", "pooled_region_psnr", "region_psnr"]


class RegionError:
    """Squared error of a region, added up over frames."""

    def __init__(self) -> None:
        self.squared = 0.0
        self.values = 0  # pixels times channels

    def add(self, image: Tensor, truth: Tensor, region: Tensor) -> None:
        """Add a frame [3, H, W] in [0, 1] with its region [H, W], a boolean mask."""
        error = (image - truth)[:, region].double()
        self.squared += float(error.square().sum())
        self.values += error.numel()

    def include(self, other: RegionError) -> None:
        """Add all frames of another."""
        self.squared += other.squared
        self.values += other.values

    def psnr(self) -> float | None:
        """The PSNR in dB, peak 1: infinite without any error, None without any pixel."""
        if self.values == 0:
            return None
        return decibels(self.squared / self.values)


def region_psnr(image: Tensor, truth: Tensor, region: Tensor) -> float | None:
    """Return the PSNR in dB of the pixels `region` [H, W] of a picture [3, H, W] in [0, 1]; None if there are none."""
    error = RegionError()
    error.add(image, truth, region)
    return error.psnr()


def pooled_region_psnr(images: Iterable[Tensor], truths: Iterable[Tensor], regions: Iterable[Tensor]) -> float | None:
    """Return the PSNR in dB of the mean squared error over the regions of all frames; None if all are empty.

    Args:
        images, truths: of every frame, [3, H, W] in [0, 1]; a tensor [F, 3, H, W] will do.
        regions: of every frame, [H, W] bool.
    """
    error = RegionError()
    for image, truth, region in zip(images, truths, regions, strict=True):
        error.add(image, truth, region)
    return error.psnr()


def mean_region_psnr(images: Iterable[Tensor], truths: Iterable[Tensor], regions: Iterable[Tensor]) -> float | None:
    """Return the mean in dB of the PSNR of each frame's region; frames without one are left out. None if all are.

    Arguments as for `pooled_region_psnr`.
    """
    scores = [region_psnr(*frame) for frame in zip(images, truths, regions, strict=True)]
    present = [score for score in scores if score is not None]
    return sum(present) / len(present) if present else None
