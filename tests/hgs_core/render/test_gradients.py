"""Gradients of every parameter: the reference against finite differences, every backend against the reference."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.comparison import compare, every_backend
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

KINDS = pytest.mark.parametrize(
    "options", [{}, {"antialiased": True}, {"depth": True}, {"antialiased": True, "depth": True}], ids=str
)
STATIC = [field.name for field in dataclasses.fields(StaticSplats)]
DYNAMIC = [field.name for field in dataclasses.fields(DynamicSplats)]


@every_backend
@KINDS
def test_float32_agrees_with_float64(backend: str, options: dict[str, Any]) -> None:
    compare(static_splats(150), dynamic_splats(120), View(camera(64, 48), 0.4, (0.2, 0.5, 0.9), **options), backend)


@every_backend
@pytest.mark.parametrize("time", [-0.2, 0.4, 1.3])
def test_motion_of_the_fifth_order_agrees_with_float64(backend: str, time: float) -> None:
    compare(static_splats(20), dynamic_splats(150, coefficients=6), View(camera(64, 48), time), backend)


@every_backend
def test_thin_splats_through_antialiasing(backend: str) -> None:
    splats = static_splats(150)
    splats.log_scales.sub_(3)
    splats.opacity_logits.add_(2)
    compare(splats, None, View(camera(64, 48), antialiased=True, depth=True), backend)


def smooth_view(**options: Any) -> View:
    """Nothing in it is decided at a threshold, so that finite differences are derivatives."""
    pose = np.eye(4)
    pose[:3, 3] = 0.1, -0.1, 0.2
    return View(Camera("smooth", 7, 5, 6.0, 6.5, 3.2, 2.6, pose), 0.4, (0.2, 0.5, 0.9), **options)


def smooth_dynamics(coefficients: int = 4) -> DynamicSplats[Tensor]:
    """Six splats, each of which covers every pixel by more than 1/255 and none by 0.99."""
    r = np.random.default_rng(5)
    motion = np.concatenate([r.uniform(-0.2, 0.2, (6, 1, 3)), r.normal(0, 0.1, (6, coefficients - 1, 3))], 1)
    motion[:, 0, 2] = np.linspace(1.5, 3, 6)
    arrays = (
        motion,
        np.stack([r.normal(size=(6, 4)), r.normal(0, 0.3, (6, 4))], 1),
        np.log(r.uniform(0.6, 1.4, (6, 3))),
        r.uniform(-0.5, 0.5, 6),
        r.uniform(0.2, 0.6, 6),
        r.uniform(0, 2, 6),
        r.uniform(size=(6, 3)),
    )
    return DynamicSplats(*(torch.tensor(array) for array in arrays))


def smooth_statics() -> StaticSplats[Tensor]:
    d = smooth_dynamics()
    return StaticSplats(d.motion[:, 0] + 0.05, d.log_scales, d.rotation[:, 0], d.opacity_logits, d.rgb.flip(0))


def weighted(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View) -> Tensor:
    render = rasterize_reference(static, dynamic, view)
    assert float(render.alpha.detach().min()) > 0.5
    assert render.depth is not None
    weights = torch.randn((5, 5, 7), generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    return (torch.cat([render.rgb, render.alpha[None], render.depth[None]]) * weights).sum()


@pytest.mark.parametrize("antialiased", [False, True])
@pytest.mark.parametrize("field", STATIC)
def test_static_gradients_are_finite_differences(field: str, antialiased: bool) -> None:
    static, view = smooth_statics(), smooth_view(depth=True, antialiased=antialiased)
    array = getattr(static, field).clone().requires_grad_()
    assert torch.autograd.gradcheck(
        lambda a: weighted(dataclasses.replace(static, **{field: a}), None, view), array, fast_mode=True
    )


@pytest.mark.parametrize("antialiased", [False, True])
@pytest.mark.parametrize("field", DYNAMIC)
def test_dynamic_gradients_are_finite_differences(field: str, antialiased: bool) -> None:
    dynamic, view = smooth_dynamics(), smooth_view(depth=True, antialiased=antialiased)
    array = getattr(dynamic, field).clone().requires_grad_()
    assert torch.autograd.gradcheck(
        lambda a: weighted(None, dataclasses.replace(dynamic, **{field: a}), view), array, fast_mode=True
    )


@pytest.mark.parametrize("field", ["motion", "time_centers"])
def test_gradients_of_motion_of_the_fifth_order_are_finite_differences(field: str) -> None:
    dynamic, view = smooth_dynamics(coefficients=6), smooth_view(depth=True)
    array = getattr(dynamic, field).clone().requires_grad_()
    assert torch.autograd.gradcheck(
        lambda a: weighted(None, dataclasses.replace(dynamic, **{field: a}), view), array, fast_mode=True
    )


def test_gradients_where_the_jacobian_is_clamped_are_finite_differences() -> None:
    static, view = smooth_statics(), smooth_view(depth=True)
    static.means[:, 0] += 3 * static.means[:, 2]
    static.log_scales.add_(1.6)

    def loss(means: Tensor) -> Tensor:
        return weighted(dataclasses.replace(static, means=means), None, view)

    assert torch.autograd.gradcheck(loss, static.means.requires_grad_(), fast_mode=True)


def test_nothing_flows_through_the_alpha_clamp() -> None:
    static = smooth_statics().take(slice(1))
    opaque = dataclasses.replace(
        static, opacity_logits=torch.full((1,), 50.0).double(), log_scales=static.log_scales + 9
    )
    opaque = opaque.map(lambda array: array.requires_grad_())
    rasterize_reference(opaque, None, smooth_view()).rgb.sum().backward()
    for name, array in opaque.items():
        assert array.grad is not None
        assert bool(array.grad.any()) == (name == "rgb"), name


@every_backend
def test_a_picture_without_splats_has_zero_gradients(backend: str) -> None:
    behind = static_splats(20)
    behind.means[:, 2] -= 20
    dead = dynamic_splats(20)
    dead.time_centers.add_(1e3)
    result = compare(behind, dead, View(camera(), depth=True), backend)
    gradients = result.gradients()
    assert len(gradients) == len(STATIC) + len(DYNAMIC)
    assert not any(gradient.any() for gradient in gradients.values())
