"""Exposure that flickers or drifts: one gain and offset per channel between a picture and its background.

Cameras adjust themselves while they record. Such a change reaches every pixel alike and is not motion; without
compensation it would raise every threshold until nothing moves.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["compensated"]

_COMPARED_PIXELS = 2048  # about so many are compared
_REWEIGHTINGS = 6  # rounds; the fit settles in three or four
_INLIER_DEVIATIONS = 2.5  # standard deviations: what is farther off moves, and does not count
_AGREEING_SHARE = 0.4  # share of the pixels that must follow one gain and offset
_DARK, _BRIGHT = 5, 250  # levels of 255 between which a channel is not clipped
_LARGEST_GAIN = 1.3  # a larger change, or its inverse, is light that changes, which moves
_LARGEST_OFFSET = 25.0  # levels of 255, likewise
_PRIOR_WEIGHT = 0.01  # weight, in shares of the pixels, of no change: it decides for pictures without contrast
_PRIOR_GAIN, _PRIOR_OFFSET = 0.05, 5.0  # deviations of the prior


def compensated(picture: npt.NDArray[np.uint8], background: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a picture [h, w, 3] with the exposure of its background [h, w, 3], as far as the still pixels tell.

    Each channel is fitted as gain times background plus offset by iteratively trimmed least squares. A channel where
    too few pixels agree on a fit, or that changed by more than a camera would, stays as it is. Clipped pixels, whose
    true value nobody knows, never end up darker than the background.
    """
    step = max(1, int(np.sqrt(picture.shape[0] * picture.shape[1] / _COMPARED_PIXELS)))
    sample, reference = picture[::step, ::step].reshape(-1, 3), background[::step, ::step].reshape(-1, 3)
    result = picture
    for channel in range(3):
        gain, offset = _fit(sample[:, channel].astype(np.float64), reference[:, channel].astype(np.float64))
        # Changes below half a level cannot be seen in whole numbers.
        if abs(gain - 1) * 255 < 0.5 and abs(offset) < 0.5:
            continue
        if result is picture:
            result = picture.copy()
        table = ((np.arange(256) - offset) / gain).round().clip(0, 255).astype(np.uint8)
        exposed = table[picture[..., channel]]
        clipped = picture[..., channel] > _BRIGHT
        result[..., channel] = np.where(clipped, np.maximum(exposed, background[..., channel]), exposed)
    return result


def _fit(values: npt.NDArray[np.float64], reference: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return gain and offset with values [N] = gain reference [N] + offset for most, or (1, 0).

    The values are fitted to the reference and not the other way round: it is a median and has less noise, which in
    the explaining variable would flatten the slope.
    """
    usable = (values > _DARK) & (values < _BRIGHT) & (reference > _DARK) & (reference < _BRIGHT)
    y, x = values[usable], reference[usable]
    if len(x) < 16:
        return 1.0, 0.0
    gain, offset = float(np.median(y / x)), 0.0
    for _ in range(_REWEIGHTINGS):
        miss = np.abs(y - gain * x - offset)
        near = miss <= _INLIER_DEVIATIONS * max(1.0, 1.4826 * float(np.median(miss)))
        weight = _PRIOR_WEIGHT * len(x)
        a, b = x[near], y[near]
        # Normal equations of the pixels, and of the prior gain = 1 +- 0.05 and offset = 0 +- 5 levels.
        slope_prior, shift_prior = weight / _PRIOR_GAIN**2, weight / _PRIOR_OFFSET**2
        matrix = np.array([[a @ a + slope_prior, a.sum()], [a.sum(), len(a) + shift_prior]])
        before = gain, offset
        gain, offset = (float(v) for v in np.linalg.solve(matrix, np.array([a @ b + slope_prior, b.sum()])))
        if (gain, offset) == before:
            break
    if near.mean() < _AGREEING_SHARE or not 1 / _LARGEST_GAIN < gain < _LARGEST_GAIN or abs(offset) > _LARGEST_OFFSET:
        return 1.0, 0.0
    return gain, offset
