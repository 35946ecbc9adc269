"""Multi-scale structural similarity (Wang, Simoncelli and Bovik, Asilomar 2003)."""

from __future__ import annotations

from torch import Tensor
from torch.nn.functional import avg_pool2d

from hgs_core.metrics.ssim import RADIUS, gaussian_window, ssim_terms

__all__ = ["SMALLEST_SIDE", "WEIGHTS", "ms_ssim"]

WEIGHTS = (0.0448, 0.2856, 0.3001, 0.2363, 0.1333)
"""Exponents of the five scales, the finest first (section 3.2 of the paper)."""

SMALLEST_SIDE = (2 * RADIUS + 1) << (len(WEIGHTS) - 1)
"""Pixels. The window must fit into the coarsest scale, which is a sixteenth of the picture: 176."""


def ms_ssim(image: Tensor, truth: Tensor) -> float | None:
    """Return the multi-scale structural similarity of two pictures [3, H, W] in [0, 1]; data range 1, 1 if equal.

    Equation 7 of the paper for each channel, then the mean of the channels. Windows lie wholly inside the picture; from
    one scale to the next, 2x2 pixels are averaged and an odd last row or column is dropped. Negative means of a scale
    count as 0, because their powers are not real.

    Returns None for a picture with a side below `SMALLEST_SIDE`: fewer scales would be another metric.
    """
    if min(image.shape[1:]) < SMALLEST_SIDE:
        return None
    # One channel at a time: its intermediate planes stay in the cache, which halves the time.
    channels = [_one_channel(image[i : i + 1], truth[i : i + 1]) for i in range(len(image))]
    return sum(channels) / len(channels)


def _one_channel(x: Tensor, y: Tensor) -> float:
    score = 1.0
    for scale, weight in enumerate(WEIGHTS):
        if scale:
            x, y = avg_pool2d(x, 2), avg_pool2d(y, 2)
        luminance, contrast_structure = ssim_terms(x, y, _blur)
        last = scale == len(WEIGHTS) - 1
        term = float((luminance * contrast_structure if last else contrast_structure).mean())
        score *= max(term, 0.0) ** weight
    return score


def _blur(planes: Tensor) -> Tensor:
    """Local means of planes [N, H, W] for the windows that lie inside them, [N, H - 10, W - 10].

    Sums of shifted planes: on a CPU many times as fast as a convolution of few channels.
    """
    for dim in (1, 2):
        length = planes.shape[dim] - 2 * RADIUS
        *outer, centre = gaussian_window(planes.dtype)[: RADIUS + 1].tolist()
        total = planes.narrow(dim, RADIUS, length) * centre
        for i, weight in enumerate(outer):
            total.add_(planes.narrow(dim, i, length), alpha=weight)
            total.add_(planes.narrow(dim, 2 * RADIUS - i, length), alpha=weight)
        planes = total
    return planes
