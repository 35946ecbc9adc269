"""SSIM against its definition, written out with numpy loops."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.metrics.ssim import gaussian_window, region_ssim, ssim, ssim_map
from hgs_core.native import library


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


@pytest.mark.parametrize("kernels", [True, False])
def test_the_score_is_the_mean_of_the_map(monkeypatch: pytest.MonkeyPatch, kernels: bool) -> None:
    if not kernels:
        monkeypatch.setattr(library, "available", lambda: False)
    generator = torch.Generator().manual_seed(0)
    x, y = (torch.rand(3, 40, 50, generator=generator) for _ in range(2))
    assert ssim(x, y) == pytest.approx(float(ssim_map(x.double(), y.double()).mean()), abs=1e-5)


def test_the_window_is_a_gaussian_of_deviation_one_and_a_half_that_sums_to_one() -> None:
    window = gaussian_window(torch.float64).numpy()
    assert window.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(window / window[5], np.exp(-(np.arange(-5, 6) ** 2) / 4.5))


def test_equal_pictures_have_ssim_one() -> None:
    picture = torch.rand(3, 20, 20, generator=torch.Generator().manual_seed(0))
    assert ssim(picture, picture) == pytest.approx(1.0, abs=1e-6)


def test_of_a_region_it_is_the_mean_of_its_pixels() -> None:
    generator = torch.Generator().manual_seed(1)
    x, y = (torch.rand(3, 20, 30, generator=generator) for _ in range(2))
    region = torch.rand(20, 30, generator=generator) < 0.1
    assert region_ssim(x, y, region) == pytest.approx(
        float(ssim_map(x.double(), y.double())[:, region].mean()), abs=1e-6
    )
    for rows, columns in ((slice(0, 3), slice(25, 30)), (slice(9, 10), slice(14, 15)), (slice(17, 20), slice(0, 9))):
        part = torch.zeros(20, 30, dtype=torch.bool)
        part[rows, columns] = True
        assert region_ssim(x, y, part) == pytest.approx(
            float(ssim_map(x.double(), y.double())[:, part].mean()), abs=1e-6
        )
    assert region_ssim(x, y, torch.zeros_like(region)) is None
