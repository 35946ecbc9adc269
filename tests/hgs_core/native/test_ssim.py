"""The compiled score against the map of torch in float64, which tests/hgs_core/metrics/test_ssim.py checks by loops."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.metrics.ssim import ssim_map
from hgs_core.native.ssim import mean_ssim
from tests.hgs_core.native.test_loss import pictures


# Narrower than the window; one pixel; no multiple of a vector; more rows than a band.
@pytest.mark.parametrize(("width", "height"), [(40, 24), (3, 4), (1, 1), (37, 211), (64, 96)])
def test_mean_over_all_windows(width: int, height: int) -> None:
    image, target = pictures(width, height)
    truth = ssim_map(torch.from_numpy(image).double(), torch.from_numpy(target).double()).mean()
    assert mean_ssim(image, target) == pytest.approx(float(truth), abs=1e-6)


def test_same_bits_for_any_number_of_threads() -> None:
    image, target = pictures(75, 300)
    assert len({mean_ssim(image, target, threads=n) for n in (1, 2, 3, 7)}) == 1


def test_refuses_pictures_it_would_misread() -> None:
    image, target = pictures(8, 8)
    with pytest.raises(ValueError, match="target must be a contiguous float32 array of shape"):
        mean_ssim(image, np.ascontiguousarray(target[:, :4]))
    with pytest.raises(ValueError, match="planes"):
        mean_ssim(image[0], target[0])
