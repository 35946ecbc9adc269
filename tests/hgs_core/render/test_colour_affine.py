"""The affine colour correction against a pixel-by-pixel transcription and finite differences."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.render.colour_affine import colour_affine, identity_affine
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from tests.hgs_core.render.scenes import camera, static_splats


def random(*shape: int) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(1), dtype=torch.float64)


def test_every_pixel_is_mapped() -> None:
    picture, affine = random(3, 4, 5), random(3, 4)
    corrected = colour_affine(picture, affine)
    for row in range(4):
        for column in range(5):
            expected = affine[:, :3] @ picture[:, row, column] + affine[:, 3]
            torch.testing.assert_close(corrected[:, row, column], expected)


def test_the_identity_changes_no_bit() -> None:
    picture = random(3, 4, 5).float()
    for affine in identity_affine(2):
        assert torch.equal(colour_affine(picture, affine), picture)


def test_gradients_are_finite_differences() -> None:
    arguments = (random(3, 3, 4).requires_grad_(), random(3, 4).requires_grad_())
    assert torch.autograd.gradcheck(colour_affine, arguments)


def test_gradients_reach_the_splats() -> None:
    static = static_splats(20).map(lambda array: array.requires_grad_())
    affine = (identity_affine(1, torch.float64)[0] + 0.1 * random(3, 4)).requires_grad_()
    colour_affine(rasterize_reference(static, None, View(camera())).rgb, affine).square().sum().backward()
    assert affine.grad is not None
    assert affine.grad.any()
    assert all(array.grad is not None and array.grad.any() for _, array in static.items())


@pytest.mark.parametrize(("picture", "affine"), [((4, 2, 2), (3, 4)), ((3, 2), (3, 4)), ((3, 2, 2), (1, 3, 4))])
def test_other_shapes_are_refused(picture: tuple[int, ...], affine: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="shape"):
        colour_affine(torch.zeros(picture), torch.zeros(affine))
