"""PSNR after the best affine colour map, against numpy's least squares."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from hgs_core.metrics.colour_corrected_psnr import ColourCorrectedError, colour_corrected_psnr


def pictures(seed: int, frames: int = 3) -> torch.Tensor:
    return torch.rand(frames, 3, 20, 30, generator=torch.Generator().manual_seed(seed))


def test_it_is_the_error_of_the_least_squares_fit() -> None:
    images, truths = pictures(0), pictures(0) * 0.7 + 0.1 * pictures(1)
    x = images.permute(0, 2, 3, 1).reshape(-1, 3).numpy().astype(np.float64)
    y = truths.permute(0, 2, 3, 1).reshape(-1, 3).numpy().astype(np.float64)
    extended = np.concatenate([x, np.ones((len(x), 1))], 1)
    fitted = extended @ np.linalg.lstsq(extended, y, rcond=None)[0]
    expected = -10 * np.log10(np.mean((fitted - y) ** 2))
    assert colour_corrected_psnr(images, truths) == pytest.approx(expected, abs=1e-6)


def test_a_camera_of_another_white_balance_is_forgiven() -> None:
    images = pictures(2)
    gains = torch.tensor([1.1, 0.9, 0.8])[:, None, None]
    assert colour_corrected_psnr(images, images * gains + 0.02) > 60


def test_what_depends_on_the_place_is_not_forgiven() -> None:
    images = pictures(3)
    truths = images.clone()
    truths[:, :, :10] = 1 - truths[:, :, :10]
    assert colour_corrected_psnr(images, truths) < 15


def test_a_constant_picture_is_no_obstacle() -> None:
    truths = pictures(4)
    expected = -10 * math.log10(float(truths.flatten(2).permute(1, 0, 2).flatten(1).var(1, correction=0).mean()))
    assert colour_corrected_psnr(torch.full_like(truths, 0.5), truths) == pytest.approx(expected, abs=1e-4)


def test_without_frames_there_is_nothing_to_say() -> None:
    assert math.isnan(ColourCorrectedError().psnr())


def test_a_region_is_judged_by_the_map_of_whole_pictures() -> None:
    """Reference: numpy's least squares over all pixels, its residuals over those of the region."""
    images, truths = pictures(5), pictures(5) * 0.8 + 0.1 * pictures(6)
    region = torch.rand(3, 20, 30, generator=torch.Generator().manual_seed(7)) < 0.2
    error = ColourCorrectedError()
    for frame in zip(images, truths, region, strict=True):
        error.add(*frame)
    x = images.permute(0, 2, 3, 1).reshape(-1, 3).numpy().astype(np.float64)
    y = truths.permute(0, 2, 3, 1).reshape(-1, 3).numpy().astype(np.float64)
    extended = np.concatenate([x, np.ones((len(x), 1))], 1)
    left = extended @ np.linalg.lstsq(extended, y, rcond=None)[0] - y
    squared, values = error.region_error()
    assert values == 3 * int(region.sum())
    assert squared == pytest.approx(float((left[region.flatten().numpy()] ** 2).sum()), rel=1e-6)
    assert error.psnr() == pytest.approx(-10 * np.log10(np.mean(left**2)), abs=1e-6)
