"""Flicker: how much the error changes over time where nothing changes in truth.

With error e(t) = picture(t) - truth(t) and S the still pixels,

    flicker = sqrt(mean over S and the channels of var_t e(t)),

the variance being the population's (divided by the number of frames). Squared, it is the part of the mean squared error
of S that comes and goes; the rest, the square of the mean error, is a picture that is wrong but steady.

The truth flickers, too: with noise, and with the shadows left in S. A picture that never changes scores that much.

The still pixels are chosen by the truth alone, so that two results are always measured on the same ones: those whose
temporal standard deviation in the truth is at most `STILL_DEVIATION` in every channel and, if masks of what moves are
given, that no mask marks in any frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import torch
from torch import Tensor

__all__ = ["STILL_DEVIATION", "Flicker", "flicker"]

STILL_DEVIATION = 0.01
"""Of the peak: above the noise of cameras and codecs, below the passing of a shadow."""

_STRIP_ROWS = 32  # rows at a time


class Flicker:
    """The flicker of one camera, from its frames one at a time; memory does not grow with their number."""

    def __init__(self) -> None:
        self._frames = 0
        self._sums: list[Tensor] = []  # error, error^2, truth, truth^2, each [3, H, W] float64
        self._moved: Tensor | None = None  # [H, W] bool

    def add(self, image: Tensor, truth: Tensor, moving: Tensor | None = None) -> None:
        """Add a frame [3, H, W] in [0, 1], and its motion mask [H, W], if there is one."""
        if not self._sums:
            self._sums = [torch.zeros_like(truth, dtype=torch.float64) for _ in range(4)]
        for first in range(0, truth.shape[1], _STRIP_ROWS):  # float64 planes of a whole picture leave the cache
            rows = slice(first, first + _STRIP_ROWS)
            true = truth[:, rows].double()
            error = image[:, rows].double() - true
            terms = (error, error.square(), true, true.square())
            for total, term in zip(self._sums, terms, strict=True):
                total[:, rows] += term
        if moving is not None:
            self._moved = moving.clone() if self._moved is None else self._moved | moving
        self._frames += 1

    def still(self) -> Tensor:
        """The still pixels, [H, W] bool.

        Raises:
            ValueError: no frame was added.
        """
        if not self._frames:
            raise ValueError("no frame was added")
        still = (self._variance(2) <= STILL_DEVIATION**2).all(dim=0)
        return still if self._moved is None else still & ~self._moved

    def value(self) -> float | None:
        """The flicker in units of the peak, or None if there are fewer than two frames or no still pixel."""
        return self._deviation(0)

    def steady(self) -> float | None:
        """The flicker that a picture scores which never changes: the truth's own; None as `value`."""
        return self._deviation(2)

    def _deviation(self, index: int) -> float | None:
        if self._frames < 2 or not bool((still := self.still()).any()):
            return None
        return math.sqrt(float(self._variance(index)[:, still].mean()))

    def _variance(self, index: int) -> Tensor:
        """Temporal variance [3, H, W] of the quantity with its sum at `index` and its sum of squares after it."""
        mean = self._sums[index] / self._frames
        return (self._sums[index + 1] / self._frames - mean.square()).clamp(min=0)


def flicker(images: Iterable[Tensor], truths: Iterable[Tensor], moving: Iterable[Tensor] | None = None) -> float | None:
    """Return the flicker of one camera's pictures in units of the peak.

    Args:
        images, truths: of every frame in order, [3, H, W] in [0, 1]; a tensor [F, 3, H, W] will do.
        moving: masks [H, W] bool of what moves in truth, of every frame, if known.

    Returns:
        None with fewer than two frames or no still pixel.
    """
    result = Flicker()
    if moving is None:
        for image, truth in zip(images, truths, strict=True):
            result.add(image, truth)
    else:
        for image, truth, mask in zip(images, truths, moving, strict=True):
            result.add(image, truth, mask)
    return result.value()
