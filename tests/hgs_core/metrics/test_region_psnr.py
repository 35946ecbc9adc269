"""The PSNR of regions against numpy's boolean indexing."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.metrics.psnr import psnr
from hgs_core.metrics.region_psnr import RegionError, mean_region_psnr, pooled_region_psnr, region_psnr


@pytest.fixture
def frames() -> tuple[Tensor, Tensor, Tensor]:
    """Images and truths [4, 3, 9, 7] and regions [4, 9, 7] of different sizes; the third is empty."""
    generator = torch.Generator().manual_seed(0)
    truths = torch.rand(4, 3, 9, 7, generator=generator)
    strength = torch.tensor([0.01, 0.1, 0.3, 0.02]).view(4, 1, 1, 1)
    images = truths + strength * torch.randn(4, 3, 9, 7, generator=generator)
    regions = torch.rand(4, 9, 7, generator=generator) < torch.tensor([0.1, 0.5, 0.0, 0.9]).view(4, 1, 1)
    return images, truths, regions


def test_pooled_is_the_psnr_of_all_pixels_together(frames: tuple[Tensor, Tensor, Tensor]) -> None:
    images, truths, regions = (t.numpy() for t in frames)
    error = (images.astype(float) - truths).transpose(0, 2, 3, 1)[regions]  # [pixels, 3]
    assert pooled_region_psnr(*frames) == pytest.approx(-10 * np.log10((error**2).mean()), abs=1e-4)


def test_the_mean_of_db_weighs_frames_equally_and_leaves_out_empty_ones(frames: tuple[Tensor, Tensor, Tensor]) -> None:
    images, truths, regions = (t.numpy() for t in frames)
    each = [-10 * np.log10(((images[i] - truths[i])[:, regions[i]] ** 2).mean()) for i in (0, 1, 3)]
    assert mean_region_psnr(*frames) == pytest.approx(np.mean(each), abs=1e-4)
    assert mean_region_psnr(*frames) != pytest.approx(pooled_region_psnr(*frames), abs=0.1)


def test_the_whole_picture_is_a_region(frames: tuple[Tensor, Tensor, Tensor]) -> None:
    image, truth = frames[0][0], frames[1][0]
    assert region_psnr(image, truth, torch.ones(9, 7, dtype=torch.bool)) == pytest.approx(psnr(image, truth), abs=1e-6)


def test_an_empty_region_has_no_score_and_one_without_error_an_infinite_one(
    frames: tuple[Tensor, Tensor, Tensor],
) -> None:
    image, truth, region = (t[0] for t in frames)
    assert region_psnr(image, truth, torch.zeros_like(region)) is None
    assert mean_region_psnr([image], [truth], [torch.zeros_like(region)]) is None
    assert pooled_region_psnr([], [], []) is None
    assert region_psnr(truth, truth, region) == math.inf


def test_errors_of_cameras_add_up(frames: tuple[Tensor, Tensor, Tensor]) -> None:
    first, second = RegionError(), RegionError()
    for i, (image, truth, region) in enumerate(zip(*frames, strict=True)):
        (first if i < 2 else second).add(image, truth, region)
    first.include(second)
    assert first.psnr() == pooled_region_psnr(*frames)
