"""Colour maps of the training cameras."""

from __future__ import annotations

import torch

from hgs_core.train.colour_correction import ColourCorrection


def test_a_fresh_correction_changes_nothing() -> None:
    picture = torch.rand(3, 4, 5)
    shown, _ = ColourCorrection(3).corrected(picture, 1)
    torch.testing.assert_close(shown.detach(), picture)


def test_the_mean_of_the_maps_stays_the_identity() -> None:
    correction = ColourCorrection(4)
    generator = torch.Generator().manual_seed(0)
    for step in range(40):
        correction.step(step % 4, torch.randn(3, 4, generator=generator), 0.01)
    torch.testing.assert_close(correction.affine.mean(0), torch.eye(3, 4))


def test_cameras_that_disagree_are_told_apart() -> None:
    # Two cameras show the same grey picture, one 10 % brighter and one 10 % darker than it is.
    truth = torch.rand(3, 8, 8, generator=torch.Generator().manual_seed(1)) * 0.5 + 0.2
    gains = (1.1, 0.9)
    correction = ColourCorrection(2)
    for step in range(2000):
        camera = step % 2
        shown, affine = correction.corrected(truth, camera)
        (shown - gains[camera] * truth).square().mean().backward()  # type: ignore[no-untyped-call]
        assert affine.grad is not None
        correction.step(camera, affine.grad, 1e-3)
    for camera, gain in enumerate(gains):
        shown, _ = correction.corrected(truth, camera)
        assert float((shown.detach() - gain * truth).abs().mean()) < 0.01


def test_a_restored_correction_goes_on_with_the_same_bits() -> None:
    one = ColourCorrection(2)
    gradient = torch.full((3, 4), 0.5)
    one.step(0, gradient, 0.01)
    state = {name: value.clone() for name, value in one.state().items()}
    two = ColourCorrection.restored(state)
    for correction in (one, two):
        correction.step(1, gradient, 0.01)
        correction.step(0, gradient, 0.01)
    assert torch.equal(one.affine, two.affine)
