"""The scores of one picture."""

from __future__ import annotations

from pathlib import Path

from torch import Tensor

from hgs_core.metrics.flip import flip, require_flip
from hgs_core.metrics.lpips import Lpips
from hgs_core.metrics.ms_ssim import ms_ssim
from hgs_core.metrics.psnr import psnr
from hgs_core.metrics.ssim import ssim

__all__ = ["PICTURE_METRICS", "PictureScorer"]

PICTURE_METRICS = ("psnr", "ssim", "ms_ssim", "lpips", "flip")
"""The names of the scores in their order."""


class PictureScorer:
    """Compares pictures by all metrics of one picture; the costly ones, LPIPS and FLIP, where they are wanted."""

    def __init__(self, lpips_weights: Path | None, with_flip: bool) -> None:
        """Load what the metrics need.

        Raises:
            InputError: the weights are not those of LPIPS, or the package of FLIP is not installed.
        """
        self._lpips = None if lpips_weights is None else Lpips(lpips_weights)
        self._flip = with_flip
        if with_flip:
            require_flip()

    def score(self, image: Tensor, truth: Tensor) -> dict[str, float | None]:
        """Compare two pictures [3, H, W] in [0, 1].

        Returns every one of `PICTURE_METRICS`, None where it was not wanted or is not defined; psnr may be infinite.
        """
        return {
            "psnr": psnr(image, truth),
            "ssim": ssim(image, truth),
            "ms_ssim": ms_ssim(image, truth),
            "lpips": self._lpips(image, truth) if self._lpips else None,
            "flip": flip(image, truth) if self._flip else None,
        }
