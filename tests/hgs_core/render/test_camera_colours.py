"""The colours of a camera: which way they are computed, and that both ways agree."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.render.camera_colours import camera_colours, camera_colours_pulled
from hgs_core.scene.camera import Camera
from tests.tolerances import assert_close

CAMERA = Camera("a", 21, 14, 20.0, 20.0, 10.0, 7.5, np.eye(4))
FALLOFF = torch.tensor([-0.2, 0.05], dtype=torch.float64)


def random(*shape: int) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(1), dtype=torch.float64)


def found(kind: torch.dtype, *, falloff: bool) -> list[Tensor]:
    """Return the picture and all gradients, computed in numbers of a kind."""
    arrays = [random(3, 14, 21), random(3, 4), *([FALLOFF] if falloff else [])]
    arguments = [array.to(kind).clone().requires_grad_() for array in arrays]
    shown = camera_colours(arguments[0], arguments[1], arguments[2] if falloff else None, CAMERA)
    (shown * random(3, 14, 21).to(kind)).sum().backward()  # type: ignore[no-untyped-call]
    return [shown.detach(), *(argument.grad for argument in arguments if argument.grad is not None)]


@pytest.mark.parametrize("falloff", [True, False])
def test_the_kernel_agrees_with_torch_in_float64(falloff: bool) -> None:
    measured, truth = (found(kind, falloff=falloff) for kind in (torch.float32, torch.float64))
    assert len(measured) == len(truth) == (4 if falloff else 3)
    for one, other in zip(measured, truth, strict=True):
        assert_close(one.numpy(), other.numpy())


def test_gradients_are_finite_differences() -> None:
    arguments = (random(3, 14, 21)[:, :2, :3], random(3, 4), FALLOFF)
    small = Camera("a", 3, 2, 20.0, 20.0, 1.4, 1.1, np.eye(4))
    learned = tuple(argument.clone().requires_grad_() for argument in arguments)
    assert torch.autograd.gradcheck(lambda *arrays: camera_colours(*arrays, small), learned)


def test_a_picture_that_lies_otherwise_in_memory_is_read_right() -> None:
    picture = random(14, 21, 3).float().permute(2, 0, 1)
    affine, falloff = random(3, 4).float(), FALLOFF.float()
    expected = camera_colours(picture.contiguous(), affine, falloff, CAMERA)
    assert torch.equal(camera_colours(picture, affine, falloff, CAMERA), expected)


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
def test_a_window_is_a_part_of_the_picture(kind: torch.dtype) -> None:
    picture, affine, falloff = random(3, 14, 21).to(kind), random(3, 4).to(kind), FALLOFF.to(kind)
    window = slice(3, 12), slice(5, 18)
    part = camera_colours(picture[:, 3:12, 5:18], affine, falloff, CAMERA, window)
    assert_close(part.numpy(), camera_colours(picture, affine, falloff, CAMERA)[:, 3:12, 5:18].numpy())


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
@pytest.mark.parametrize(
    ("picture", "affine", "falloff"),
    [((4, 14, 21), (3, 4), 2), ((3, 14, 20), (3, 4), 2), ((3, 14, 21), (4, 4), 2), ((3, 14, 21), (3, 4), 3)],
)
def test_other_shapes_are_refused(
    kind: torch.dtype, picture: tuple[int, ...], affine: tuple[int, ...], falloff: int
) -> None:
    with pytest.raises(InputError, match="shape"):
        camera_colours(
            torch.zeros(picture, dtype=kind), torch.zeros(affine, dtype=kind), torch.zeros(falloff, dtype=kind), CAMERA
        )


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
@pytest.mark.parametrize("falloff", [True, False])
def test_a_gradient_is_pulled_back_without_autograd_as_with_it(kind: torch.dtype, falloff: bool) -> None:
    picture, affine, gradient = (random(*shape).to(kind) for shape in ((3, 9, 13), (3, 4), (3, 9, 13)))
    window, coefficients = (slice(3, 12), slice(5, 18)), FALLOFF.to(kind) if falloff else None
    own = picture.clone().requires_grad_(True)
    camera_colours(own, affine, coefficients, CAMERA, window).backward(gradient)  # type: ignore[no-untyped-call]
    pulled = camera_colours_pulled(gradient, picture, affine, coefficients, CAMERA, window)
    assert not pulled.requires_grad
    assert own.grad is not None
    assert torch.equal(pulled, own.grad)
