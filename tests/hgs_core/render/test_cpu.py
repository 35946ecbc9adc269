"""The compiled backend against the float64 reference backend: pictures, every gradient, statistics, masks."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.native import library
from hgs_core.render.cpu import rasterize_cpu
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import Render, ScreenStatistics, View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.tolerances import assert_close

pytestmark = pytest.mark.skipif(not library.instruction_set(), reason="hgs was built without its C++ kernels")

BACKGROUND = (0.2, 0.5, 0.9)


@dataclasses.dataclass
class Result:
    render: Render
    static: StaticSplats[Tensor] | None
    dynamic: DynamicSplats[Tensor] | None
    statistics: ScreenStatistics


def differentiate(
    backend: Any,
    dtype: torch.dtype,
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    view: Camera,
    **options: Any,
) -> Result:
    """Render, and differentiate a random weighting of the picture and its alpha."""

    def leaf(array: Tensor) -> Tensor:
        return array.detach().to(dtype, copy=True).requires_grad_()

    static = static.map(leaf) if static is not None else None
    dynamic = dynamic.map(leaf) if dynamic is not None else None
    statistics = ScreenStatistics.zeros(len(static or ()) + len(dynamic or ()))
    render = backend(static, dynamic, View(view, 0.4, BACKGROUND, statistics=statistics, **options))
    generator = torch.Generator().manual_seed(0)
    weights = torch.randn((4, view.height, view.width), generator=generator, dtype=torch.float64).to(dtype)
    loss = (render.rgb * weights[:3]).sum() + (render.alpha * weights[3]).sum()
    if loss.requires_grad:
        loss.backward()
    return Result(render, static, dynamic, statistics)


def compare(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: Camera, **options: Any
) -> None:
    # The reference starts from the same float32 values.
    static = static.map(lambda a: a.float().double()) if static is not None else None
    dynamic = dynamic.map(lambda a: a.float().double()) if dynamic is not None else None
    truth = differentiate(rasterize_reference, torch.float64, static, dynamic, view, **options)
    fast = differentiate(rasterize_cpu, torch.float32, static, dynamic, view, **options)
    assert_close(fast.render.rgb.detach().numpy(), truth.render.rgb.detach().numpy(), "rgb")
    assert_close(fast.render.alpha.detach().numpy(), truth.render.alpha.detach().numpy(), "alpha")
    for one, other in ((fast.static, truth.static), (fast.dynamic, truth.dynamic)):
        if one is None or other is None:
            continue
        for (name, a), (_, b) in zip(one.items(), other.items(), strict=True):
            if b.grad is None:
                assert a.grad is None or not a.grad.any(), name
                continue
            assert a.grad is not None, name
            assert_close(a.grad.numpy(), b.grad.numpy(), name)
    assert_close(fast.statistics.grad_norm_sum, truth.statistics.grad_norm_sum, "grad_norm_sum")
    np.testing.assert_array_equal(fast.statistics.count, truth.statistics.count)


def relative_error(actual: Tensor, reference: Tensor) -> float:
    return float(
        torch.linalg.vector_norm(actual.detach() - reference.detach()) / torch.linalg.vector_norm(reference.detach())
    )


def test_statics() -> None:
    compare(static_splats(150), None, camera())


def test_dynamics() -> None:
    compare(None, dynamic_splats(150), camera())


# Sizes that end within a tile, within a vector, and below one tile.
@pytest.mark.parametrize(("width", "height"), [(64, 48), (75, 41), (9, 5)])
def test_both_sets(width: int, height: int) -> None:
    compare(static_splats(200), dynamic_splats(150), camera(width, height))


@pytest.mark.parametrize("gradients", ["all", "static", "dynamic", "none"])
def test_gradient_sets(gradients: str) -> None:
    compare(static_splats(100), dynamic_splats(80), camera(), gradients=gradients)


def test_masked_tiles_are_neither_drawn_nor_differentiated() -> None:
    mask: npt.NDArray[np.bool_] = np.random.default_rng(0).random((3, 4)) < 0.5
    view = camera(60, 44)
    compare(static_splats(100), dynamic_splats(80), view, tile_mask=mask)
    render = rasterize_cpu(static_splats(100), None, View(view, background=BACKGROUND, tile_mask=mask))
    hidden = ~np.kron(mask, np.ones((16, 16), np.bool_))[:44, :60]
    assert (render.alpha.numpy()[hidden] == 0).all()
    assert (render.rgb.numpy()[:, hidden] == np.array(BACKGROUND, np.float32)[:, None]).all()


def test_splats_beyond_the_field_of_view_where_the_jacobian_is_clamped() -> None:
    splats = static_splats(100)
    splats.means[:, 0] *= 3
    splats.means[:, 1] *= 3
    splats.log_scales.add_(1.5)
    compare(splats, None, camera())


def test_long_thin_splats() -> None:
    splats = static_splats(60)
    splats.log_scales[:, 0] += 3  # hundreds of pixels long and one wide: conics nearly lose their digits
    splats.log_scales[:, 1:] -= 4
    splats = splats.map(lambda a: a.float())
    truth = differentiate(rasterize_reference, torch.float64, splats, None, camera(64, 48))
    fast = differentiate(rasterize_cpu, torch.float32, splats, None, camera(64, 48))
    assert relative_error(fast.render.rgb, truth.render.rgb) < 1e-4
    for (name, a), (_, b) in zip(fast.static.items(), truth.static.items(), strict=True):  # type: ignore[union-attr]
        assert relative_error(a.grad, b.grad) < 1e-4, name


def test_opaque_splats_that_finish_pixels_and_reach_the_alpha_clamp() -> None:
    splats = static_splats(300)
    splats.opacity_logits.add_(5)
    compare(splats, None, camera())


def test_zero_quaternions_are_the_identity_without_gradient() -> None:
    splats = static_splats(30)
    splats.quats[::2] = 0
    compare(splats, None, camera())


def test_equal_depths_are_drawn_in_order_of_index_statics_first() -> None:
    def disc(rgb: tuple[float, float, float]) -> tuple[Tensor, ...]:
        rows = ([0, 0, 2.0], [-1.0, -1, -1], [1.0, 0, 0, 0], 0.0, rgb)
        return tuple(torch.tensor([row]) for row in rows)

    mean, log_scale, quat, logit, red = disc((1, 0, 0))
    green, blue = torch.tensor([[0.0, 1, 0]]), torch.tensor([[0.0, 0, 1]])
    static = StaticSplats(
        torch.cat([mean, mean]), torch.cat([log_scale] * 2), torch.cat([quat] * 2), torch.cat([logit] * 2),
        torch.cat([red, green]),
    )  # fmt: skip
    dynamic = DynamicSplats(
        torch.cat([mean[:, None], torch.zeros(1, 3, 3)], 1), torch.stack([quat, torch.zeros(1, 4)], 1), log_scale,
        logit, torch.zeros(1), torch.zeros(1), blue,
    )  # fmt: skip
    view = Camera("front", 17, 17, 20.0, 20.0, 8.5, 8.5, np.eye(4))
    centre = rasterize_cpu(static, dynamic, View(view, 0.0)).rgb[:, 8, 8]
    torch.testing.assert_close(centre, torch.tensor([0.5, 0.25, 0.125]), rtol=1e-5, atol=1e-6)


def test_parameters_that_require_no_gradient_get_none() -> None:
    static = static_splats(50, dtype=torch.float32)
    static.means.requires_grad_()
    dynamic = dynamic_splats(50, dtype=torch.float32)
    rasterize_cpu(static, dynamic, View(camera(), 0.4)).rgb.sum().backward()
    assert static.means.grad is not None
    assert static.means.grad.any()
    assert all(array.grad is None for name, array in static.items() if name != "means")
    assert all(array.grad is None for _, array in dynamic.items())


def test_without_gradients_the_picture_is_no_part_of_a_graph() -> None:
    static = static_splats(20, dtype=torch.float32).map(lambda a: a.requires_grad_())
    assert not rasterize_cpu(static, None, View(camera(), gradients="none")).rgb.requires_grad
    with torch.no_grad():
        assert not rasterize_cpu(static, None, View(camera())).rgb.requires_grad


@pytest.mark.parametrize("empty_static", [True, False])
@pytest.mark.parametrize("empty_dynamic", [True, False])
def test_empty_sets(empty_static: bool, empty_dynamic: bool) -> None:
    static = static_splats(0 if empty_static else 20, dtype=torch.float32).map(lambda a: a.requires_grad_())
    dynamic = dynamic_splats(0 if empty_dynamic else 20, dtype=torch.float32).map(lambda a: a.requires_grad_())
    rasterize_cpu(static, dynamic, View(camera(), 0.4)).rgb.sum().backward()
    for _, array in (*static.items(), *dynamic.items()):
        assert array.grad is not None
        assert array.grad.shape == array.shape
    assert rasterize_cpu(None, None, View(camera(), background=BACKGROUND)).alpha.sum() == 0


def test_one_graph_can_be_differentiated_twice() -> None:
    static = static_splats(40, dtype=torch.float32).map(lambda a: a.requires_grad_())
    render = rasterize_cpu(static, None, View(camera()))
    other = rasterize_cpu(static, None, View(camera(64, 64)))  # must not take the first one's workspace
    (first,) = torch.autograd.grad(render.rgb.sum(), static.means, retain_graph=True)
    (second,) = torch.autograd.grad(render.rgb.sum(), static.means)
    (third,) = torch.autograd.grad(other.rgb.sum(), static.means)
    assert torch.equal(first, second)
    assert not torch.equal(first, third)


def test_a_parameter_changed_before_the_backward_pass_is_noticed() -> None:
    static = static_splats(10, dtype=torch.float32).map(lambda a: a.requires_grad_())
    loss = rasterize_cpu(static, None, View(camera())).rgb.sum()
    with torch.no_grad():
        static.means.add_(1)
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        loss.backward()
