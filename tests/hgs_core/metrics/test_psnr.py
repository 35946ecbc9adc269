"""PSNR against its definition, worked out by hand."""

from __future__ import annotations

import math

import pytest
import torch

from hgs_core.metrics.psnr import decibels, psnr


def test_psnr_is_its_definition() -> None:
    image = torch.zeros(3, 4, 4)
    assert psnr(image, torch.full_like(image, 0.1)) == pytest.approx(20.0, abs=1e-5)
    assert psnr(image, image) == math.inf


def test_the_square_is_the_mean_over_all_pixels_and_channels() -> None:
    image = torch.zeros(3, 5, 8)
    image[1, 2, 3] = 0.6
    assert psnr(image, torch.zeros(3, 5, 8)) == pytest.approx(10 * math.log10(120 / 0.36), abs=1e-5)


@pytest.mark.parametrize(
    ("squared_error", "expected"), [(1.0, 0.0), (0.001, 30.0), (4.0, -10 * math.log10(4)), (0.0, math.inf)]
)
def test_decibels_are_ten_times_the_logarithm_of_the_inverse(squared_error: float, expected: float) -> None:
    assert decibels(squared_error) == pytest.approx(expected)
