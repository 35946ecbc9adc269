"""Flicker against its definition in numpy, over all frames at once."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.metrics.flicker import STILL_DEVIATION, Flicker, flicker


@pytest.fixture
def clip() -> tuple[Tensor, Tensor]:
    """Images and truths [5, 3, 8, 10]: the right half of the truth moves, the left one has noise of 0.004."""
    generator = torch.Generator().manual_seed(0)
    still = torch.rand(3, 8, 10, generator=generator)
    truths = still + 0.004 * torch.randn(5, 3, 8, 10, generator=generator)
    truths[..., 5:] += 0.3 * torch.randn(5, 3, 8, 5, generator=generator)
    images = truths + 0.1 + 0.05 * torch.randn(5, 3, 8, 10, generator=generator)
    return images, truths


def test_it_is_the_temporal_deviation_of_the_error_where_the_truth_is_still(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = (t.double().numpy() for t in clip)
    still = (truths.std(axis=0) <= STILL_DEVIATION).all(axis=0)  # [8, 10]
    assert still[:, :5].all()
    assert not still[:, 5:].all()
    expected = np.sqrt((images - truths).var(axis=0)[:, still].mean())
    assert flicker(*clip) == pytest.approx(expected, rel=1e-9)


def test_it_is_the_part_of_the_squared_error_that_a_steady_error_does_not_explain(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = (t[..., :5].double() for t in clip)
    error = images - truths
    steady = error.mean(dim=0).square().mean()
    assert (flicker(images, truths) or 0) ** 2 + float(steady) == pytest.approx(float(error.square().mean()), rel=1e-9)


def test_a_steady_error_does_not_flicker(clip: tuple[Tensor, Tensor]) -> None:
    _, truths = clip
    assert flicker(truths.double() + 0.2, truths) == pytest.approx(0, abs=1e-7)


def test_a_picture_that_never_changes_flickers_as_the_truth_does(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = clip
    gathered = Flicker()
    for image, truth in zip(images, truths, strict=True):
        gathered.add(image, truth)
    assert gathered.steady() == pytest.approx(flicker(images[:1].expand_as(images), truths), rel=1e-9)


def test_the_still_pixels_do_not_depend_on_the_pictures_that_are_scored(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = clip
    chosen = []
    for pictures in (images, torch.zeros_like(images), truths):
        result = Flicker()
        for image, truth in zip(pictures, truths, strict=True):
            result.add(image, truth)
        chosen.append(result.still())
    assert torch.equal(chosen[0], chosen[1])
    assert torch.equal(chosen[0], chosen[2])


def test_a_pixel_that_any_mask_marks_is_left_out(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = clip
    masks = torch.zeros(5, 8, 10, dtype=torch.bool)
    masks[2, :, 1:] = True
    masks[4, :4] = True
    expected = (images - truths).double().var(dim=0, correction=0)[:, 4:, 0].mean().sqrt()
    assert flicker(images, truths, masks) == pytest.approx(float(expected), rel=1e-9)


def test_without_two_frames_or_a_still_pixel_there_is_none(clip: tuple[Tensor, Tensor]) -> None:
    images, truths = clip
    assert flicker(images[:1], truths[:1]) is None
    assert flicker(images, truths, torch.ones(5, 8, 10, dtype=torch.bool)) is None
    assert Flicker().value() is None
    with pytest.raises(ValueError, match="no frame"):
        Flicker().still()
