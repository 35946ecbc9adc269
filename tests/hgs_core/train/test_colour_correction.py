"""Colour maps and lens falloffs of the training cameras."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.render.lens_falloff import falloff_gain
from hgs_core.scene.camera import Camera
from hgs_core.train.colour_correction import CameraColours, ColourCorrection

CAMERA = Camera("a", 16, 12, 10.0, 10.0, 8.0, 6.0, np.eye(4))
PICTURE = torch.rand(3, 12, 16, generator=torch.Generator().manual_seed(1)) * 0.5 + 0.2


def learned(correction: ColourCorrection, truths: list[torch.Tensor], steps: int) -> None:
    """Let the cameras of one picture learn how they show it, in turn."""
    for step in range(steps):
        place = step % len(truths)
        colours = correction.learning(place)
        (colours.shown(PICTURE, CAMERA) - truths[place]).square().mean().backward()  # type: ignore[no-untyped-call]
        correction.step(place, colours.gradient(), 1e-3, 2e-3)


@pytest.mark.parametrize("falloff", [True, False])
def test_a_fresh_correction_changes_nothing(falloff: bool) -> None:
    shown = ColourCorrection(3, falloff=falloff).of(1).shown(PICTURE, CAMERA)
    torch.testing.assert_close(shown, PICTURE)


def test_the_mean_of_the_maps_stays_the_identity() -> None:
    correction = ColourCorrection(4)
    generator = torch.Generator().manual_seed(0)
    for step in range(40):
        gradient = CameraColours(torch.randn(3, 4, generator=generator), torch.randn(2, generator=generator))
        correction.step(step % 4, gradient, 0.01, 0.01)
    torch.testing.assert_close(correction.affine.mean(0), torch.eye(3, 4))


def test_cameras_that_disagree_are_told_apart() -> None:
    # Two cameras show the same picture, one 10 % brighter and one 10 % darker than it is.
    correction = ColourCorrection(2)
    truths = [1.1 * PICTURE, 0.9 * PICTURE]
    learned(correction, truths, 2000)
    for place, truth in enumerate(truths):
        assert float((correction.of(place).shown(PICTURE, CAMERA) - truth).abs().mean()) < 0.01


def test_lenses_that_darken_corners_are_found_each_by_itself() -> None:
    correction = ColourCorrection(2)
    truths = [PICTURE * falloff_gain(torch.tensor(falloff), CAMERA) for falloff in ([-0.2, -0.05], [0.1, 0.0])]
    learned(correction, truths, 3000)
    for place, truth in enumerate(truths):
        assert float((correction.of(place).shown(PICTURE, CAMERA) - truth).abs().mean()) < 0.01
    assert correction.falloff is not None
    corners = 1 + correction.falloff.sum(1)
    assert corners.tolist() == pytest.approx([0.75, 1.1], abs=0.06)


def test_no_falloff_is_steeper_than_to_a_quarter() -> None:
    correction = ColourCorrection(1)
    for _ in range(10):
        correction.step(0, CameraColours(torch.zeros(3, 4), torch.tensor([1.0, -1.0])), 0.0, 0.1)
    assert correction.falloff is not None
    assert correction.falloff.tolist() == [[-0.375, 0.375]]


def test_falloffs_that_are_not_learned_stay_away() -> None:
    correction = ColourCorrection(2, falloff=False)
    learned(correction, [0.9 * PICTURE, 1.1 * PICTURE], 4)
    assert correction.of(0).falloff is None


@pytest.mark.parametrize("falloff", [True, False])
def test_a_restored_correction_goes_on_with_the_same_bits(falloff: bool) -> None:
    one = ColourCorrection(2, falloff=falloff)
    gradient = CameraColours(torch.full((3, 4), 0.5), torch.tensor([0.5, -0.1]) if falloff else None)
    one.step(0, gradient, 0.01, 0.01)
    state = {name: None if value is None else value.clone() for name, value in one.state().items()}
    two = ColourCorrection.restored(state)
    for correction in (one, two):
        correction.step(1, gradient, 0.01, 0.01)
        correction.step(0, gradient, 0.01, 0.01)
    assert torch.equal(one.affine, two.affine)
    if falloff:
        assert one.falloff is not None
        assert two.falloff is not None
        assert torch.equal(one.falloff, two.falloff)
    else:
        assert one.falloff is two.falloff is None


def test_a_correction_moves_with_its_falloffs() -> None:
    moved = ColourCorrection(2).to(torch.device("meta"))
    assert moved.falloff is not None
    assert moved.affine.device.type == moved.falloff.device.type == "meta"
