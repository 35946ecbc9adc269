"""The scores of one picture."""

from __future__ import annotations

from pathlib import Path

from torch import Tensor

from hgs_core.metrics.flip import flip, require_flip
from hgs_core.metrics.lpips import Lpips
from hgs_core.metrics.ms_ssim import ms_ssim
from hgs_core.metrics.psnr import psnr
from hgs_core.metrics.ssim import region_ssim, ssim

__all__ = ["PICTURE_METRICS", "REGION_METRICS", "RIG_METRICS", "PictureScorer"]

PICTURE_METRICS = ("psnr", "ssim", "ms_ssim", "lpips", "flip")
"""The names of the scores of whole pictures in their order."""

REGION_METRICS = ("ssim_dynamic", "lpips_dynamic")
"""The names of moving pixels' scores that are means over pixels."""

RIG_METRICS = ("psnr", "ssim", "lpips")
"""The names of the scores of whole pictures that are also taken as the training cameras would show them."""


class PictureScorer:
    """Compares pictures by all metrics of one picture; the costly ones, LPIPS and FLIP, where they are wanted."""

    def __init__(self, lpips_weights: Path | None, with_flip: bool) -> None:
        """Load the models of the metrics.

        Raises:
            InputError: the weights are not those of LPIPS, or the package of FLIP is not installed.
        """
        self._lpips = None if lpips_weights is None else Lpips(lpips_weights)
        self._flip = with_flip
        if with_flip:
            require_flip()

    def score(self, image: Tensor, truth: Tensor, moving: Tensor | None = None) -> dict[str, float | None]:
        """Compare two pictures [3, H, W] in [0, 1], of which the pixels `moving` [H, W] move (None: unknown).

        Returns every one of `PICTURE_METRICS` and `REGION_METRICS`, None where it was not wanted or is not defined;
        psnr may be infinite.
        """
        return {
            **self.score_as_rig(image, truth, moving),
            "ms_ssim": ms_ssim(image, truth),
            "flip": flip(image, truth) if self._flip else None,
        }

    def score_as_rig(self, image: Tensor, truth: Tensor, moving: Tensor | None = None) -> dict[str, float | None]:
        """Compare two pictures as `score` does, by `RIG_METRICS` and `REGION_METRICS` alone."""
        lpips = lpips_dynamic = None
        if self._lpips and moving is not None:
            lpips, lpips_dynamic = self._lpips.with_region(image, truth, moving)
        elif self._lpips:
            lpips = self._lpips(image, truth)
        return {
            "psnr": psnr(image, truth),
            "ssim": ssim(image, truth),
            "lpips": lpips,
            "ssim_dynamic": None if moving is None else region_ssim(image, truth, moving),
            "lpips_dynamic": lpips_dynamic,
        }
