"""The compiled backend against the float64 reference backend, and how it behaves inside autograd."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from torch import Tensor

from hgs_core.native import library
from hgs_core.render.cpu import rasterize_cpu
from hgs_core.render.types import Gradients, View
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.comparison import compare
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats

pytestmark = pytest.mark.skipif(not library.instruction_set(), reason="hgs was built without its C++ kernels")

BACKGROUND = (0.2, 0.5, 0.9)


def view(width: int = 40, height: int = 24, **options: Any) -> View:
    return View(camera(width, height), 0.4, BACKGROUND, **options)


def test_statics() -> None:
    compare(static_splats(150), None, view())


def test_dynamics() -> None:
    compare(None, dynamic_splats(150), view())


# Sizes that end within a tile, within a vector, and below one tile.
@pytest.mark.parametrize(("width", "height"), [(64, 48), (75, 41), (9, 5)])
def test_both_sets(width: int, height: int) -> None:
    compare(static_splats(200), dynamic_splats(150), view(width, height))


@pytest.mark.parametrize("gradients", ["all", "static", "dynamic", "none"])
def test_gradient_sets(gradients: Gradients) -> None:
    compare(static_splats(100), dynamic_splats(80), view(gradients=gradients))


def test_masked_tiles_are_neither_drawn_nor_differentiated() -> None:
    mask: npt.NDArray[np.bool_] = np.random.default_rng(0).random((3, 4)) < 0.5
    result = compare(static_splats(100), dynamic_splats(80), view(60, 44, tile_mask=mask))
    hidden = ~np.kron(mask, np.ones((16, 16), np.bool_))[:44, :60]
    pictures = result.pictures()
    assert (pictures["alpha"].numpy()[hidden] == 0).all()
    assert (pictures["rgb"].numpy()[:, hidden] == np.array(BACKGROUND, np.float32)[:, None]).all()


def test_opaque_splats_that_finish_pixels_and_reach_the_alpha_clamp() -> None:
    splats = static_splats(300)
    splats.opacity_logits.add_(5)
    compare(splats, None, view())


def test_equal_depths_are_drawn_in_order_of_index_statics_first() -> None:
    def disc(rgb: tuple[float, float, float]) -> tuple[Tensor, ...]:
        rows = ([0, 0, 2.0], [-1.0, -1, -1], [1.0, 0, 0, 0], 0.0, rgb)
        return tuple(torch.tensor([row]) for row in rows)

    mean, log_scale, quat, logit, red = disc((1, 0, 0))
    green, blue = torch.tensor([[0.0, 1, 0]]), torch.tensor([[0.0, 0, 1]])
    static = StaticSplats(
        torch.cat([mean, mean]),
        torch.cat([log_scale] * 2),
        torch.cat([quat] * 2),
        torch.cat([logit] * 2),
        torch.cat([red, green]),
    )
    dynamic = DynamicSplats(
        torch.cat([mean[:, None], torch.zeros(1, 3, 3)], 1),
        torch.stack([quat, torch.zeros(1, 4)], 1),
        log_scale,
        logit,
        torch.zeros(1),
        torch.zeros(1),
        blue,
    )
    front = Camera("front", 17, 17, 20.0, 20.0, 8.5, 8.5, np.eye(4))
    centre = rasterize_cpu(static, dynamic, View(front)).rgb[:, 8, 8]
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
