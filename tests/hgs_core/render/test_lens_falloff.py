"""The falloff of a lens against a pixel-by-pixel transcription and finite differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.render.lens_falloff import falloff_gain
from hgs_core.scene.camera import Camera

CAMERA = Camera("a", 9, 6, 8.0, 8.0, 4.1, 3.2, np.eye(4))
FALLOFF = torch.tensor([-0.3, 0.1], dtype=torch.float64)


def test_every_pixel_is_darkened_by_its_distance_to_the_principal_point() -> None:
    gain = falloff_gain(FALLOFF, CAMERA)
    assert gain.shape == (6, 9)
    for row in range(6):
        for column in range(9):
            r = math.hypot(column + 0.5 - 4.1, row + 0.5 - 3.2) / (math.hypot(9, 6) / 2)
            assert float(gain[row, column]) == pytest.approx(1 - 0.3 * r**2 + 0.1 * r**4, rel=1e-6)


def test_a_picture_of_another_size_is_darkened_alike() -> None:
    """A pixel of the half picture lies in the middle of four pixels of the whole one, which r^2 bends around it."""
    whole = Camera("a", 80, 60, 70.0, 70.0, 41.0, 31.0, np.eye(4))
    means = torch.nn.functional.avg_pool2d(falloff_gain(FALLOFF, whole)[None], 2)[0]
    torch.testing.assert_close(falloff_gain(FALLOFF, whole.scaled(0.5)), means, atol=1e-4, rtol=0)


def test_no_falloff_changes_no_bit() -> None:
    assert torch.equal(falloff_gain(torch.zeros(2), CAMERA), torch.ones(6, 9))


def test_gradients_are_finite_differences() -> None:
    assert torch.autograd.gradcheck(lambda falloff: falloff_gain(falloff, CAMERA), FALLOFF.clone().requires_grad_())


def test_other_shapes_are_refused() -> None:
    with pytest.raises(InputError, match=r"falloff: shape \(3,\)"):
        falloff_gain(torch.zeros(3), CAMERA)
