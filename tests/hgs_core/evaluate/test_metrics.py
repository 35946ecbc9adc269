"""PSNR and SSIM against their definitions, written out with numpy loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from hgs_core.metrics.psnr import psnr
from hgs_core.metrics.ssim import ssim, ssim_map


def test_psnr_is_its_definition() -> None:
    image = torch.zeros(3, 4, 4)
    assert psnr(image, torch.full_like(image, 0.1)) == pytest.approx(20.0, abs=1e-5)
    assert psnr(image, image) == math.inf


def test_ssim_is_its_definition_pixel_by_pixel() -> None:
    r = np.random.default_rng(0)
    x = r.random((14, 17))
    y = np.clip(x + 0.2 * r.normal(size=x.shape), 0, 1)
    weights = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    weights /= weights.sum()
    window = np.outer(weights, weights)
    px, py = np.pad(x, 5), np.pad(y, 5)
    expected = np.empty_like(x)
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            a, b = px[i : i + 11, j : j + 11], py[i : i + 11, j : j + 11]
            ma, mb = (window * a).sum(), (window * b).sum()
            va, vb = (window * a * a).sum() - ma**2, (window * b * b).sum() - mb**2
            cov = (window * a * b).sum() - ma * mb
            expected[i, j] = ((2 * ma * mb + 1e-4) * (2 * cov + 9e-4)) / ((ma**2 + mb**2 + 1e-4) * (va + vb + 9e-4))
    got = ssim_map(torch.tensor(x)[None], torch.tensor(y)[None])[0].numpy()
    np.testing.assert_allclose(got, expected, atol=1e-12)


def test_the_score_is_the_mean_of_the_map() -> None:
    generator = torch.Generator().manual_seed(0)
    x, y = (torch.rand(3, 40, 50, generator=generator) for _ in range(2))
    assert ssim(x, y) == pytest.approx(float(ssim_map(x.double(), y.double()).mean()), abs=1e-5)


def test_equal_pictures_have_ssim_one() -> None:
    picture = torch.rand(3, 20, 20, generator=torch.Generator().manual_seed(0))
    assert ssim(picture, picture) == pytest.approx(1.0, abs=1e-6)
