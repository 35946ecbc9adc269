"""Projection against extended precision, where plain formulas lose their digits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from hgs_core.render.moment import moment_of_static
from hgs_core.render.projection import project, rotation_matrices
from tests.hgs_core.render.scenes import camera, static_splats


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("length", [1e-11, 1.0, 1e15, 1e18, 5e37])
def test_rotations_do_not_depend_on_the_length_of_quaternions(length: float, dtype: torch.dtype) -> None:
    unit = torch.nn.functional.normalize(static_splats(20).quats, dim=1)
    expected = rotation_matrices(unit)
    torch.testing.assert_close(expected @ expected.mT, torch.eye(3, dtype=torch.float64).expand(20, 3, 3))
    quats = (unit * length).to(dtype).requires_grad_()
    matrices = rotation_matrices(quats)
    torch.testing.assert_close(matrices.double(), expected, rtol=0, atol=4 * torch.finfo(dtype).eps)
    weights = torch.randn(20, 3, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    (gradient,) = torch.autograd.grad((matrices.double() * weights).sum(), quats)
    unit.requires_grad_()
    (at_unit,) = torch.autograd.grad((rotation_matrices(unit) * weights).sum(), unit)
    torch.testing.assert_close(gradient.double() * length, at_unit, rtol=0, atol=100 * torch.finfo(dtype).eps)


@pytest.mark.parametrize("length", [0.0, 1e-15, 9e-13])
def test_quaternions_without_a_direction_are_the_identity_without_gradient(length: float) -> None:
    quats = torch.full((2, 4), length / 2, dtype=torch.float64, requires_grad=True)
    matrices = rotation_matrices(quats)
    matrices.sum().backward()  # type: ignore[no-untyped-call]
    torch.testing.assert_close(matrices, torch.eye(3, dtype=torch.float64).expand(2, 3, 3))
    assert quats.grad is not None
    assert not quats.grad.any()


def test_needles_keep_the_digits_of_their_determinant() -> None:
    splats = static_splats(60)
    splats.log_scales[:] = torch.log(torch.tensor([1e3, 1e-1, 1e-1]))
    view = camera()
    seen = project(moment_of_static(splats), view)
    assert len(seen.index) > 20
    # The covariance in extended precision, from the same float64 inputs.
    rows = splats.take(seen.index)
    wide = np.longdouble
    pose = view.world_to_camera.astype(wide)
    x, y, z = pose[:3, :3] @ rows.means.numpy().astype(wide).T + pose[:3, 3:]
    q = rows.quats.numpy().astype(wide)
    w, i, j, k = (q / np.sqrt((q * q).sum(1, keepdims=True))).T
    R = np.array(
        [
            [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
            [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
            [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
        ]
    )
    u = np.clip(x / z, -(view.cx + 0.15 * view.width) / view.fx, (1.15 * view.width - view.cx) / view.fx)
    v = np.clip(y / z, -(view.cy + 0.15 * view.height) / view.fy, (1.15 * view.height - view.cy) / view.fy)
    zero = np.zeros_like(z)
    J = np.array([[view.fx / z, zero, -view.fx * u / z], [zero, view.fy / z, -view.fy * v / z]])
    M = np.einsum("abk,bc,cdk->kad", J, pose[:3, :3], R) * np.exp(rows.log_scales.numpy().astype(wide))[:, None]
    xx, xy, yy = (M[:, 0] ** 2).sum(1) + 0.3, (M[:, 0] * M[:, 1]).sum(1), (M[:, 1] ** 2).sum(1) + 0.3
    det = (np.cross(M[:, 0], M[:, 1]) ** 2).sum(1) + wide(0.3) * (xx + yy) - wide(0.09)
    expected = np.stack([np.sqrt(yy / det), -xy / np.sqrt(yy * det), 1 / np.sqrt(yy)], 1)
    np.testing.assert_allclose(seen.factors.numpy(), expected.astype(np.float64), rtol=1e-11)


def test_what_is_not_drawn_leaves_no_trace_in_the_gradient() -> None:
    splats = static_splats(30)
    splats.log_scales[::3] = 700  # overflows float64 when squared
    splats = splats.map(lambda array: array.requires_grad_())
    seen = project(moment_of_static(splats), camera())
    (seen.means.sum() + seen.factors.sum() + seen.depths.sum()).backward()
    for name, array in splats.items():
        if name not in ("opacity_logits", "rgb"):
            assert array.grad is not None
            assert torch.isfinite(array.grad).all(), name
            assert not array.grad[::3].any(), name


def test_antialiasing_fades_thin_splats_down_to_its_floor() -> None:
    sharp = dataclasses.replace(static_splats(40), opacity_logits=torch.full((40,), 5.0).double())
    sharp.log_scales[:20] = 3
    sharp.log_scales[20:] = -20
    plain, faded = (project(moment_of_static(sharp), camera(), antialiased) for antialiased in (False, True))
    ratio = faded.opacities / plain.opacities
    large = plain.index < 20
    assert (ratio[large] > 0.9).all()
    torch.testing.assert_close(ratio[~large], torch.full_like(ratio[~large], 0.005))
