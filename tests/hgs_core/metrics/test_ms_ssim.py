"""MS-SSIM against the paper's formula with two-dimensional windows in numpy, and against pytorch-msssim."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.metrics.ms_ssim import SMALLEST_SIDE, ms_ssim
from tests.hgs_core.evaluate.pictures import wave_pair

Plane = npt.NDArray[np.float64]


def reference(x: Plane, y: Plane) -> float:
    """Wang, Simoncelli and Bovik, 2003, equation 7, for one plane [H, W]."""
    taps = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    window = np.outer(taps, taps) / taps.sum() ** 2

    def mean(plane: Plane) -> Plane:
        return np.einsum("ijkl,kl->ij", np.lib.stride_tricks.sliding_window_view(plane, (11, 11)), window)

    score = 1.0
    for j, exponent in enumerate((0.0448, 0.2856, 0.3001, 0.2363, 0.1333)):
        mx, my = mean(x), mean(y)
        vx, vy, vxy = mean(x * x) - mx**2, mean(y * y) - my**2, mean(x * y) - mx * my
        term = (2 * vxy + 0.03**2) / (vx + vy + 0.03**2)
        if j == 4:
            term *= (2 * mx * my + 0.01**2) / (mx**2 + my**2 + 0.01**2)
        score *= term.mean() ** exponent
        h, w = x.shape[0] // 2, x.shape[1] // 2
        x, y = (p[: 2 * h, : 2 * w].reshape(h, 2, w, 2).mean(axis=(1, 3)) for p in (x, y))
    return score


def tensors(height: int, width: int) -> tuple[torch.Tensor, torch.Tensor]:
    x, y = wave_pair(height, width)
    return torch.from_numpy(x), torch.from_numpy(y)


def test_it_is_the_papers_formula_also_with_odd_sides() -> None:
    x, y = tensors(179, 187)
    expected = np.mean([reference(a, b) for a, b in zip(x.numpy(), y.numpy(), strict=True)])
    assert ms_ssim(x, y) == pytest.approx(expected, rel=1e-9)
    assert ms_ssim(x.float(), y.float()) == pytest.approx(expected, rel=1e-5)


def test_it_agrees_with_pytorch_msssim() -> None:
    # pytorch_msssim 1.0.0: ms_ssim(x[None], y[None], data_range=1), whose window is float32
    assert ms_ssim(*tensors(192, 208)) == pytest.approx(0.94316213, abs=1e-6)


def test_equal_pictures_have_one_and_opposite_ones_zero() -> None:
    x, _ = tensors(180, 180)
    assert ms_ssim(x, x) == pytest.approx(1, abs=1e-12)
    noise = torch.rand(3, 180, 180, generator=torch.Generator().manual_seed(0))
    assert ms_ssim(noise, 1 - noise) == 0


def test_a_picture_too_small_for_five_scales_has_no_score() -> None:
    assert SMALLEST_SIDE == 176
    assert ms_ssim(*tensors(176, 176)) is not None
    assert ms_ssim(*tensors(175, 400)) is None
