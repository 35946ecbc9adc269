"""The Triton kernels against the float64 reference backend, and how they behave inside autograd."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from hgs_core.render.triton.rasterize import rasterize_triton
from hgs_core.render.types import Gradients, View
from hgs_core.scene import StaticSplats
from tests.hgs_core.render.comparison import check_case, compare, differentiate
from tests.hgs_core.render.hard_cases import front
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats
from tests.hgs_core.render.triton.small import BACKGROUND, cropped, view

SEEDS = st.integers(0, 2**31)
FEW = settings(max_examples=2, deadline=None, derandomize=True, database=None, phases=[Phase.generate])


@FEW
@given(SEEDS)
def test_both_sets(seed: int) -> None:
    compare(static_splats(25, seed), dynamic_splats(25, seed + 1), view(), "triton")


@FEW
@given(SEEDS)
def test_depth_and_antialiasing(seed: int) -> None:
    options: dict[str, Any] = {"depth": True, "antialiased": True}
    compare(static_splats(20, seed), dynamic_splats(20, seed + 1), view(**options), "triton")


def test_motion_of_the_fifth_order() -> None:
    compare(None, dynamic_splats(40, coefficients=6), view(), "triton")


def test_thin_splats_through_antialiasing() -> None:
    splats = static_splats(40)
    splats.log_scales.sub_(3)
    splats.opacity_logits.add_(2)
    compare(splats, None, view(antialiased=True, depth=True), "triton")


@pytest.mark.parametrize("gradients", ["static", "dynamic", "none"])
def test_gradient_sets(gradients: Gradients) -> None:
    compare(static_splats(15), dynamic_splats(15), view(gradients=gradients), "triton")


def test_masked_tiles_are_neither_drawn_nor_differentiated() -> None:
    mask: npt.NDArray[np.bool_] = np.array([[True, False], [False, True]])
    result = compare(static_splats(30), dynamic_splats(20), view(30, 28, tile_mask=mask, depth=True), "triton")
    hidden = ~np.kron(mask, np.ones((16, 16), np.bool_))[:28, :30]
    pictures = result.pictures()
    assert (pictures["alpha"].numpy()[hidden] == 0).all()
    assert (pictures["depth"].numpy()[hidden] == 0).all()
    assert (pictures["rgb"].numpy()[:, hidden] == np.array(BACKGROUND, np.float32)[:, None]).all()


def test_a_mask_without_any_tile() -> None:
    mask: npt.NDArray[np.bool_] = np.zeros((2, 2), np.bool_)
    compare(static_splats(10), None, view(30, 28, tile_mask=mask), "triton")


def test_opaque_splats_that_finish_pixels_and_reach_the_alpha_clamp() -> None:
    splats = static_splats(120)
    splats.opacity_logits.add_(5)
    compare(splats, None, view(16, 16), "triton")


def test_every_bit_is_the_same_each_time() -> None:
    one, other = (
        differentiate("triton", torch.float32, static_splats(20), dynamic_splats(20), view()) for _ in range(2)
    )
    for a, b in ((one.pictures(), other.pictures()), (one.gradients(), other.gradients())):
        assert all(torch.equal(a[name], b[name]) for name in a)


# The ones that other code than the pixels' decides, and those that ask most of float32.
HARD = (
    "needles",
    "needles_antialiased",
    "needles_across_the_picture",
    "screen_filling",
    "two_scales_vanish",
    "scales_that_overflow_harm_no_other",
    "centres_at_the_near_plane",
    "directions_beyond_the_clamp",
    "a_million_units_from_the_origin",
    "means_that_overflow_harm_no_other",
    "equal_depths",
    "opacity_one",
    "colours_at_the_limit",
    "zero_quaternions",
    "largest_quaternions",
    "time_precision_infinite",
    "everything_dead",
    "one_pixel",
    "no_splats",
)


@pytest.mark.parametrize("name", HARD)
def test_hard_cases(name: str) -> None:
    check_case(cropped(name), "triton")


def test_more_tile_entries_than_can_be_counted_are_refused_before_memory_is_taken() -> None:
    splats = StaticSplats(
        torch.tensor([[0.0, 0.0, 1.0]]).repeat(129, 1),
        torch.full((129, 3), 12.0),
        torch.zeros(129, 4),
        torch.zeros(129),
        torch.zeros(129, 3),
    )
    with pytest.raises(RuntimeError, match="more than 2\\^31 - 1"):
        rasterize_triton(splats, None, View(front(1 << 24, 256)))


def test_parameters_that_require_no_gradient_get_none() -> None:
    static = static_splats(15, dtype=torch.float32)
    static.means.requires_grad_()
    dynamic = dynamic_splats(15, dtype=torch.float32)
    rasterize_triton(static, dynamic, View(camera(16, 16), 0.4)).rgb.sum().backward()
    assert static.means.grad is not None
    assert static.means.grad.any()
    assert all(array.grad is None for name, array in static.items() if name != "means")
    assert all(array.grad is None for _, array in dynamic.items())


def test_without_gradients_the_picture_is_no_part_of_a_graph() -> None:
    static = static_splats(5, dtype=torch.float32).map(lambda a: a.requires_grad_())
    assert not rasterize_triton(static, None, View(camera(16, 16), gradients="none")).rgb.requires_grad
    with torch.no_grad():
        assert not rasterize_triton(static, None, View(camera(16, 16))).rgb.requires_grad


@pytest.mark.parametrize("empty_static", [True, False])
@pytest.mark.parametrize("empty_dynamic", [True, False])
def test_empty_sets(empty_static: bool, empty_dynamic: bool) -> None:
    static = static_splats(0 if empty_static else 5, dtype=torch.float32).map(lambda a: a.requires_grad_())
    dynamic = dynamic_splats(0 if empty_dynamic else 5, dtype=torch.float32).map(lambda a: a.requires_grad_())
    rasterize_triton(static, dynamic, View(camera(16, 16), 0.4)).rgb.sum().backward()
    for _, array in (*static.items(), *dynamic.items()):
        assert array.grad is not None
        assert array.grad.shape == array.shape
    assert rasterize_triton(None, None, View(camera(16, 16), background=BACKGROUND)).alpha.sum() == 0


def test_one_graph_can_be_differentiated_twice() -> None:
    static = static_splats(10, dtype=torch.float32).map(lambda a: a.requires_grad_())
    render = rasterize_triton(static, None, View(camera(16, 16)))
    (first,) = torch.autograd.grad(render.rgb.sum(), static.means, retain_graph=True)
    (second,) = torch.autograd.grad(render.rgb.sum(), static.means)
    assert torch.equal(first, second)


def test_a_parameter_changed_before_the_backward_pass_is_noticed() -> None:
    static = static_splats(5, dtype=torch.float32).map(lambda a: a.requires_grad_())
    loss = rasterize_triton(static, None, View(camera(16, 16))).rgb.sum()
    with torch.no_grad():
        static.means.add_(1)
    with pytest.raises(RuntimeError, match="modified by an inplace operation"):
        loss.backward()
