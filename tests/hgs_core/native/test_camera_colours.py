"""The fused colours of a camera against their formula in float64, differentiated by torch."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from hgs_core.native.camera_colours import LensAxis, camera_shown, camera_shown_backward
from tests.tolerances import assert_close

AFFINE = np.array([[1.1, 0.05, -0.02, 0.03], [0.0, 0.9, 0.1, -0.05], [-0.1, 0.02, 1.05, 0.01]], np.float32)
FALLOFF = np.array([-0.3, 0.12], np.float32)

# Whole vectors and parts of one; one pixel; more rows than one thread takes at a time.
SIZES = [(64, 40), (37, 211), (1, 1), (3, 70), (47, 5)]


def lens(width: int, height: int) -> LensAxis:
    return LensAxis(0.45 * width, 0.6 * height, math.hypot(width, height) / 2)


def pictures(width: int, height: int) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    r = np.random.default_rng(0)
    shape = (3, height, width)
    return r.uniform(0, 1, shape).astype(np.float32), r.normal(0, 1, shape).astype(np.float32)


def reference(picture: torch.Tensor, affine: torch.Tensor, falloff: torch.Tensor, axis: LensAxis) -> torch.Tensor:
    _, height, width = picture.shape
    x = (torch.arange(width, dtype=torch.float64) + 0.5 - axis.x) / axis.half_diagonal
    y = (torch.arange(height, dtype=torch.float64) + 0.5 - axis.y) / axis.half_diagonal
    squared = x[None] ** 2 + y[:, None] ** 2
    gain = 1 + falloff[0] * squared + falloff[1] * squared**2
    return torch.einsum("ij,jhw->ihw", affine[:, :3], picture * gain) + affine[:, 3, None, None]


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_pictures(width: int, height: int) -> None:
    axis, (picture, _) = lens(width, height), pictures(width, height)
    truth = reference(*(torch.tensor(array, dtype=torch.float64) for array in (picture, AFFINE, FALLOFF)), axis)
    assert_close(camera_shown(picture, AFFINE, FALLOFF, axis), truth.numpy())


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_gradients(width: int, height: int) -> None:
    axis, (picture, gradient) = lens(width, height), pictures(width, height)
    arguments = [torch.tensor(a, dtype=torch.float64, requires_grad=True) for a in (picture, AFFINE, FALLOFF)]
    reference(*arguments, axis).backward(torch.tensor(gradient, dtype=torch.float64))  # type: ignore[no-untyped-call]
    found = camera_shown_backward(gradient, picture, AFFINE, FALLOFF, axis)
    for (name, array), argument in zip(found._asdict().items(), arguments, strict=True):
        assert argument.grad is not None
        assert_close(array, argument.grad.numpy(), name)


def test_colours_that_change_nothing_change_no_bit() -> None:
    picture, _ = pictures(37, 20)
    shown = camera_shown(picture, np.eye(3, 4, dtype=np.float32), np.zeros(2, np.float32), lens(37, 20))
    assert shown.tobytes() == picture.tobytes()


def test_same_bits_for_any_number_of_threads() -> None:
    axis, (picture, gradient) = lens(75, 300), pictures(75, 300)
    results = set()
    for threads in (1, 2, 3, 7):
        shown = camera_shown(picture, AFFINE, FALLOFF, axis, threads=threads)
        found = camera_shown_backward(gradient, picture, AFFINE, FALLOFF, axis, threads=threads)
        results.add(b"".join(array.tobytes() for array in (shown, *found)))
    assert len(results) == 1


def test_refuses_arrays_it_would_misread() -> None:
    axis, (picture, gradient) = lens(8, 8), pictures(8, 8)
    with pytest.raises(ValueError, match="planes"):
        camera_shown(picture[0], AFFINE, FALLOFF, axis)
    with pytest.raises(ValueError, match="affine must be a contiguous float32 array of shape"):
        camera_shown(picture, AFFINE.astype(np.float64), FALLOFF, axis)
    with pytest.raises(ValueError, match="falloff must be a contiguous float32 array of shape"):
        camera_shown(picture, AFFINE, FALLOFF[:1], axis)
    with pytest.raises(ValueError, match="gradient must be a contiguous float32 array of shape"):
        camera_shown_backward(gradient[:, :4], picture, AFFINE, FALLOFF, axis)
