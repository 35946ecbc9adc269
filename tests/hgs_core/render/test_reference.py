"""The reference backend against a per-pixel transcription of docs/numerics.md and against finite differences."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.camera import Camera
from hgs_core.render.projection import rotation_matrices
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import ScreenStatistics, View
from hgs_core.scene import DynamicSplats, StaticSplats
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats


def draw_pixel_by_pixel(
    static: StaticSplats[Any], dynamic: DynamicSplats[Any], view: Camera, time: float
) -> npt.NDArray[np.float64]:
    """docs/numerics.md written down for one splat and one pixel at a time: [4, H, W]."""
    splats = []
    for row in zip(*(a.numpy() for _, a in static.items()), strict=True):
        mean, log_scale, quat, logit, rgb = row
        splats.append((mean, log_scale, quat, 1 / (1 + math.exp(-logit)), rgb))
    for row in zip(*(a.numpy() for _, a in dynamic.items()), strict=True):
        motion, rotation, log_scale, logit, center, precision, rgb = row
        d = time - center
        opacity = math.exp(-math.exp(precision) * d * d) / (1 + math.exp(-logit))
        splats.append((sum(motion[k] * d**k for k in range(4)), log_scale, rotation[0] + d * rotation[1], opacity, rgb))
    W, t = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    ellipses = []
    for mean, log_scale, quat, opacity, rgb in splats:
        x, y, z = W @ mean + t
        if z < view.near or opacity < 1 / 255:
            continue
        w, i, j, k = quat / np.linalg.norm(quat)
        R = np.array([
            [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
            [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
            [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
        ])  # fmt: skip
        covariance = R @ np.diag(np.exp(2 * log_scale)) @ R.T
        mx, my = 0.15 * view.width / view.fx, 0.15 * view.height / view.fy
        u = min(max(x / z, -view.cx / view.fx - mx), (view.width - view.cx) / view.fx + mx)
        v = min(max(y / z, -view.cy / view.fy - my), (view.height - view.cy) / view.fy + my)
        J = np.array([[view.fx / z, 0, -view.fx * u / z], [0, view.fy / z, -view.fy * v / z]])
        screen = J @ W @ covariance @ W.T @ J.T + 0.3 * np.eye(2)
        center = np.array([view.fx * x / z + view.cx, view.fy * y / z + view.cy])
        ellipses.append((z, center, np.linalg.inv(screen), opacity, rgb))
    ellipses.sort(key=lambda ellipse: ellipse[0])
    image = np.zeros((4, view.height, view.width))
    for row in range(view.height):
        for column in range(view.width):
            passed, colour = 1.0, np.zeros(3)
            for _, center, conic, opacity, rgb in ellipses:
                delta = np.array([column + 0.5, row + 0.5]) - center
                alpha = min(0.99, opacity * math.exp(-0.5 * delta @ conic @ delta))
                if alpha < 1 / 255:
                    continue
                if passed * (1 - alpha) <= 1e-4:
                    break
                colour += passed * alpha * rgb
                passed *= 1 - alpha
            image[:, row, column] = *colour, 1 - passed
    return image


@pytest.mark.parametrize("time", [0.0, 0.4, 1.0])
def test_picture_is_the_specified_one(time: float) -> None:
    static, dynamic, view = static_splats(60), dynamic_splats(40), camera()
    expected = draw_pixel_by_pixel(static, dynamic, view, time)
    render = rasterize_reference(static, dynamic, View(view, time))
    np.testing.assert_allclose(render.rgb.numpy(), expected[:3], atol=1e-12)
    np.testing.assert_allclose(render.alpha.numpy(), expected[3], atol=1e-12)


def test_a_stack_of_opaque_splats_stops_before_the_last_one_allowed() -> None:
    one = static_splats(1)
    stack = StaticSplats(
        torch.tensor([[0.0, 0.0, 2.0 + k] for k in range(8)], dtype=torch.float64),
        torch.full((8, 3), 2.5, dtype=torch.float64),
        one.quats.expand(8, 4),
        torch.full((8,), math.log(0.97 / 0.03), dtype=torch.float64),
        torch.eye(8, 3, dtype=torch.float64),
    )
    render = rasterize_reference(stack, None, View(camera()))
    # T after two splats is about 1e-3; the third would take it below 1e-4 where it covers as much: it is not drawn.
    row, column = divmod(int(render.rgb[0].argmax()), render.alpha.shape[1])
    colour = render.rgb[:, row, column]
    assert colour[0] > colour[1] > 0
    assert colour[2] == 0
    assert render.alpha[row, column] == pytest.approx(float(colour[0] + colour[1]), abs=1e-12)


def test_background_shows_where_nothing_covers() -> None:
    render = rasterize_reference(static_splats(3), None, View(camera(), background=(0.2, 0.4, 0.6)))
    uncovered = render.alpha == 0
    assert uncovered.any()
    for channel, value in enumerate((0.2, 0.4, 0.6)):
        assert (render.rgb[channel][uncovered] == value).all()


def test_no_splats_give_the_background() -> None:
    for static in (None, static_splats(0)):
        render = rasterize_reference(static, None, View(camera(), background=(0.5, 0.0, 1.0)))
        assert render.alpha.abs().max() == 0
        assert render.rgb[2].min() == 1


def test_masked_tiles_stay_background_and_others_do_not_change() -> None:
    static, dynamic, view = static_splats(60), dynamic_splats(40), camera()
    mask = np.array([[True, False, True], [False, True, False]])
    whole = rasterize_reference(static, dynamic, View(view, 0.4))
    part = rasterize_reference(static, dynamic, View(view, 0.4, tile_mask=mask))
    pixels = torch.tensor(mask).repeat_interleave(16, 0).repeat_interleave(16, 1)[: view.height, : view.width]
    torch.testing.assert_close(part.rgb[:, pixels], whole.rgb[:, pixels], rtol=0, atol=0)
    assert part.alpha[~pixels].max() == 0


@pytest.mark.parametrize("field", [f.name for f in dataclasses.fields(DynamicSplats)])
def test_dynamic_gradients_are_finite_differences(field: str) -> None:
    static, dynamic, view = static_splats(6), dynamic_splats(6), camera(24, 16)
    weights = torch.rand(4, 16, 24, generator=torch.Generator().manual_seed(3), dtype=torch.float64)

    def loss(array: torch.Tensor) -> torch.Tensor:
        render = rasterize_reference(static, dataclasses.replace(dynamic, **{field: array}), View(view, 0.4))
        return (render.rgb * weights[:3]).sum() + (render.alpha * weights[3]).sum()

    array = getattr(dynamic, field).clone().requires_grad_()
    # 1/255 and 1e-4 cut-offs make the picture jump by up to 4e-3; eps is small enough that none is crossed here.
    assert torch.autograd.gradcheck(loss, array, eps=1e-8, atol=1e-3, rtol=1e-3)


@pytest.mark.parametrize("field", [f.name for f in dataclasses.fields(StaticSplats)])
def test_static_gradients_are_finite_differences(field: str) -> None:
    static, view = static_splats(8), camera(24, 16)

    def loss(array: torch.Tensor) -> torch.Tensor:
        return rasterize_reference(dataclasses.replace(static, **{field: array}), None, View(view)).rgb.square().sum()

    array = getattr(static, field).clone().requires_grad_()
    assert torch.autograd.gradcheck(loss, array, eps=1e-8, atol=1e-3, rtol=1e-3)


def test_gradient_sets_leave_the_other_set_alone() -> None:
    static = static_splats(20).map(lambda a: a.requires_grad_())
    dynamic = dynamic_splats(20).map(lambda a: a.requires_grad_())
    rasterize_reference(static, dynamic, View(camera(), 0.4, gradients="dynamic")).rgb.sum().backward()
    assert static.means.grad is None
    assert dynamic.motion.grad is not None


def test_zero_quaternions_are_the_identity() -> None:
    quats = torch.zeros(2, 4, dtype=torch.float64, requires_grad=True)
    matrices = rotation_matrices(quats)
    matrices.sum().backward()  # type: ignore[no-untyped-call]
    torch.testing.assert_close(matrices, torch.eye(3, dtype=torch.float64).expand(2, 3, 3))
    assert quats.grad is not None
    assert torch.isfinite(quats.grad).all()


def test_statistics_count_what_was_seen() -> None:
    static = static_splats(30).map(lambda a: a.requires_grad_())
    dynamic = dynamic_splats(20).map(lambda a: a.requires_grad_())
    statistics = ScreenStatistics.zeros(50)
    for _ in range(2):
        rasterize_reference(static, dynamic, View(camera(), 0.4, statistics=statistics)).rgb.sum().backward()
    seen = statistics.count > 0
    assert set(np.unique(statistics.count)) <= {0, 2}
    assert seen[:30].any()
    assert seen[30:].any()
    assert (statistics.grad_norm_sum[~seen] == 0).all()
