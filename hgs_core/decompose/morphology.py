"""Box filters and binary morphology with square windows, in plain numpy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["box_sum", "close", "despeckle", "dilate"]


def box_sum(values: npt.NDArray[np.int16], radius: int) -> npt.NDArray[np.int16]:
    """Return the sum over the (2 radius + 1)^2 window around each pixel [H, W, ...]; outside the picture is zero.

    Sums wrap around at 32768: the caller keeps magnitudes below 32768 / (2 radius + 1)^2.
    """
    for axis in (0, 1):
        total = values.copy()
        for shift in range(1, radius + 1):
            if axis == 0:
                total[shift:] += values[:-shift]
                total[:-shift] += values[shift:]
            else:
                total[:, shift:] += values[:, :-shift]
                total[:, :-shift] += values[:, shift:]
        values = total
    return values


def despeckle(mask: npt.NDArray[np.bool_], radius: int, share: float) -> npt.NDArray[np.bool_]:
    """Keep a pixel of the mask if its window is set for at least `share` of its area."""
    count = box_sum(mask.astype(np.int16), radius)
    return mask & (count >= share * (2 * radius + 1) ** 2)


def dilate(mask: npt.NDArray[np.bool_], radius: int) -> npt.NDArray[np.bool_]:
    """Set every pixel that has a set pixel within `radius` rows and columns."""
    grown = mask
    # Three copies of what is grown already make a wider window. A step of at most one more than what is done keeps
    # this true at the border, where a copy would have to start outside the picture.
    done = 0
    while done < radius:
        step = min(done + 1, radius - done)
        grown = _spread(_spread(grown, step, 0), step, 1)
        done += step
    return grown if done else mask.copy()


def close(mask: npt.NDArray[np.bool_], radius: int) -> npt.NDArray[np.bool_]:
    """Fill gaps narrower than 2 radius pixels: dilation, then erosion; the border does not erode."""
    return ~dilate(~dilate(mask, radius), radius) | mask


def _spread(mask: npt.NDArray[np.bool_], step: int, axis: int) -> npt.NDArray[np.bool_]:
    """Return mask(x - step) | mask(x) | mask(x + step) along an axis."""
    grown = mask.copy()
    if axis == 0:
        grown[step:] |= mask[:-step]
        grown[:-step] |= mask[step:]
    else:
        grown[:, step:] |= mask[:, :-step]
        grown[:, :-step] |= mask[:, step:]
    return grown
