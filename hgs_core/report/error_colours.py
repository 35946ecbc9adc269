"""The colours of error maps: black over violet, red and orange to pale yellow, with even steps for the eye.

The path lies in OKLab (Ottosson, "A perceptual color space for image processing", 2020): lightness rises while the hue
turns, and the table is resampled so that neighbours are equally far apart. Errors that differ by the same amount look
equally different, in grey as well, because lightness rises all the way.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles

__all__ = ["ERROR_RANGE", "colour_table", "error_picture", "oklab", "srgb"]

ERROR_RANGE = 0.2
"""The error that has the last colour: mean absolute difference of R, G and B, sRGB in [0, 1]."""

# Knots of the path: lightness, chroma, hue in degrees (beyond 360 to keep turning); inside the sRGB gamut.
_LIGHTNESS = (0.13, 0.35, 0.55, 0.72, 0.86, 0.97)
_CHROMA = (0.02, 0.13, 0.17, 0.158, 0.133, 0.07)
_HUE = (285.0, 305.0, 365.0, 405.0, 440.0, 465.0)

_LMS_FROM_RGB = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LAB_FROM_LMS = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)

Bytes = npt.NDArray[np.uint8]


@functools.cache
def colour_table() -> Bytes:
    """Return the colours [256, 3], sRGB, of errors from 0 to `ERROR_RANGE` and beyond."""
    knots, fine = np.linspace(0, 1, len(_LIGHTNESS)), np.linspace(0, 1, 4001)
    lightness, chroma = np.interp(fine, knots, _LIGHTNESS), np.interp(fine, knots, _CHROMA)
    hue = np.deg2rad(np.interp(fine, knots, _HUE))
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(lab, axis=0), axis=1))])
    even = np.interp(np.linspace(0, way[-1], 256), way, fine)
    table = srgb(np.stack([np.interp(even, fine, lab[:, i]) for i in range(3)], axis=1))
    return np.asarray(np.rint(np.clip(table, 0, 1) * 255), np.uint8)


def error_picture(error: npt.NDArray[np.floating[Any]]) -> Bytes:
    """Return the colours [H, W, 3] of errors [H, W]; those above `ERROR_RANGE` have the last colour."""
    return np.asarray(colour_table()[np.rint(np.clip(error / ERROR_RANGE, 0, 1) * 255).astype(np.uint8)])


def oklab(rgb: Doubles) -> Doubles:
    """Return the OKLab coordinates [N, 3] of sRGB colours [N, 3] in [0, 1]."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.cbrt(linear @ _LMS_FROM_RGB.T) @ _LAB_FROM_LMS.T)


def srgb(lab: Doubles) -> Doubles:
    """Return the sRGB colours [N, 3] of OKLab coordinates [N, 3]; outside [0, 1] for colours beyond a screen's."""
    lms = (lab @ np.linalg.inv(_LAB_FROM_LMS).T) ** 3
    linear = lms @ np.linalg.inv(_LMS_FROM_RGB).T
    bent = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.asarray(np.where(linear <= 0.0031308, linear * 12.92, bent))
