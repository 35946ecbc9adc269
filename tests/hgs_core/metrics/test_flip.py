"""FLIP against the paper's pipeline, written out with two-dimensional filters in float64."""

from __future__ import annotations

import sys

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.metrics.flip import PIXELS_PER_DEGREE, flip, require_flip
from tests.hgs_core.evaluate.pictures import wave_pair

Array = npt.NDArray[np.float64]

# Linear sRGB to XYZ of illuminant D65, whose white is the image of (1, 1, 1).
TO_XYZ = np.array(
    [
        [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
    ]
)
WHITE = TO_XYZ.sum(axis=1)


def filtered(plane: Array, kernel: Array) -> Array:
    """Correlate a plane [H, W] with a kernel [K, K]; the border repeats."""
    radius = len(kernel) // 2
    views = np.lib.stride_tricks.sliding_window_view(np.pad(plane, radius, mode="edge"), kernel.shape)
    return np.einsum("ijkl,kl->ij", views, kernel)


def linear_rgb(picture: Array) -> Array:
    return np.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4)


def ycxcz(rgb: Array) -> Array:
    x, y, z = np.tensordot(TO_XYZ, rgb, 1) / WHITE[:, None, None]
    return np.stack((116 * y - 16, 500 * (x - y), 200 * (y - z)))


def hunt_lab(rgb: Array) -> Array:
    """L*a*b* with the Hunt effect: chroma counts less in the dark."""
    ratio = np.tensordot(TO_XYZ, rgb, 1) / WHITE[:, None, None]
    delta = 6 / 29
    x, y, z = np.where(ratio > delta**3, np.cbrt(ratio), ratio / (3 * delta**2) + 4 / 29)
    lightness = 116 * y - 16
    return np.stack((lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)))


def hyab(a: Array, b: Array) -> Array:
    return np.abs(a[0] - b[0]) + np.hypot(a[1] - b[1], a[2] - b[2])


def colour_difference(a: Array, b: Array) -> Array:
    """Section 4.1: contrast sensitivity, perceptual space, HyAB, redistribution of errors."""
    curves = ((1.0, 0.0047, 0.0, 1e-5), (1.0, 0.0053, 0.0, 1e-5), (34.1, 0.04, 13.5, 0.025))  # a1, b1, a2, b2
    radius = int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi**2)) * PIXELS_PER_DEGREE))
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1] / PIXELS_PER_DEGREE
    seen = []
    for picture in (a, b):
        channels = []
        for plane, (a1, b1, a2, b2) in zip(ycxcz(linear_rgb(picture)), curves, strict=True):
            kernel = sum(
                p * np.sqrt(np.pi / q) * np.exp(-(np.pi**2) * (x**2 + y**2) / q) for p, q in ((a1, b1), (a2, b2))
            )
            channels.append(filtered(plane, kernel / kernel.sum()))
        lum = (channels[0] + 16) / 116
        xyz = np.stack((lum + channels[1] / 500, lum, lum - channels[2] / 200)) * WHITE[:, None, None]
        seen.append(hunt_lab(np.clip(np.tensordot(np.linalg.inv(TO_XYZ), xyz, 1), 0, 1)))
    green, blue = (np.array(rgb, float).reshape(3, 1, 1) for rgb in ((0, 1, 0), (0, 0, 1)))
    largest = hyab(hunt_lab(green), hunt_lab(blue)).item() ** 0.7
    power = hyab(*seen) ** 0.7
    knee, at_knee = 0.4 * largest, 0.95
    return np.where(power < knee, at_knee / knee * power, at_knee + (power - knee) / (largest - knee) * (1 - at_knee))


def feature_difference(a: Array, b: Array) -> Array:
    """Section 4.2: edges and points."""
    deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE
    radius = int(np.ceil(3 * deviation))
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].astype(float)
    gaussian = np.exp(-(x**2 + y**2) / (2 * deviation**2))
    strengths = []
    for kernel in (-x * gaussian, (x**2 / deviation**2 - 1) * gaussian):
        positive, negative = kernel[kernel > 0].sum(), -kernel[kernel < 0].sum()
        kernel = np.where(kernel > 0, kernel / positive, kernel / negative)
        lum = [(ycxcz(linear_rgb(picture))[0] + 16) / 116 for picture in (a, b)]
        strengths.append([np.hypot(filtered(plane, kernel), filtered(plane, kernel.T)) for plane in lum])
    difference = np.maximum(*(np.abs(p - q) for p, q in strengths))
    return np.sqrt(difference / np.sqrt(2))


def test_it_is_the_papers_pipeline() -> None:
    pytest.importorskip("flip_evaluator", reason="flip-evaluator is not installed (extra eval)")
    a, b = wave_pair(40, 52)
    expected = (colour_difference(a, b) ** (1 - feature_difference(a, b))).mean()
    got = flip(torch.from_numpy(b).float(), torch.from_numpy(a).float())
    assert got == pytest.approx(expected, rel=1e-4)
    assert got > 0.05


def test_equal_pictures_have_zero_and_green_against_blue_one() -> None:
    pytest.importorskip("flip_evaluator", reason="flip-evaluator is not installed (extra eval)")
    green, blue = torch.zeros(3, 20, 30), torch.zeros(3, 20, 30)
    green[1], blue[2] = 1, 1
    assert flip(green, green) == 0
    assert flip(green, blue) == pytest.approx(1, abs=1e-3)


def test_without_its_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    with pytest.raises(InputError, match=r"pip install 'hgs\[eval\]'"):
        require_flip()
