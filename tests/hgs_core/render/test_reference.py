"""The reference backend against a per-pixel transcription of docs/numerics.md."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.render.reference import contributions_reference, rasterize_reference
from hgs_core.render.types import ScreenStatistics, View
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera
from tests.hgs_core.render.scenes import camera, dynamic_splats, static_splats


def draw_pixel_by_pixel(
    static: StaticSplats[Any], dynamic: DynamicSplats[Any], view: Camera, time: float, antialiased: bool = False
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """docs/numerics.md written down for one splat and one pixel at a time.

    Returns colour, coverage and depth, [5, H, W], and the weights of all splats, [N + M, H, W].
    """
    splats = []
    for row in zip(*(a.numpy() for _, a in static.items()), strict=True):
        mean, log_scale, quat, logit, rgb = row
        splats.append((mean, log_scale, quat, 1 / (1 + math.exp(-logit)), rgb))
    for row in zip(*(a.numpy() for _, a in dynamic.items()), strict=True):
        motion, rotation, log_scale, logit, center, precision, rgb = row
        d = time - center
        opacity = math.exp(-math.exp(precision) * d * d) / (1 + math.exp(-logit))
        splats.append(
            (sum(motion[k] * d**k for k in range(len(motion))), log_scale, rotation[0] + d * rotation[1], opacity, rgb)
        )
    W, t = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    ellipses = []
    for index, (mean, log_scale, quat, opacity, rgb) in enumerate(splats):
        x, y, z = W @ mean + t
        if z < view.near or opacity < 1 / 255:
            continue
        w, i, j, k = quat / np.linalg.norm(quat)
        R = np.array(
            [
                [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
                [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
                [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
            ]
        )
        covariance = R @ np.diag(np.exp(2 * log_scale)) @ R.T
        mx, my = 0.15 * view.width / view.fx, 0.15 * view.height / view.fy
        u = min(max(x / z, -view.cx / view.fx - mx), (view.width - view.cx) / view.fx + mx)
        v = min(max(y / z, -view.cy / view.fy - my), (view.height - view.cy) / view.fy + my)
        J = np.array([[view.fx / z, 0, -view.fx * u / z], [0, view.fy / z, -view.fy * v / z]])
        sharp = J @ W @ covariance @ W.T @ J.T
        screen = sharp + 0.3 * np.eye(2)
        if antialiased:
            opacity *= math.sqrt(max(0.005**2, np.linalg.det(sharp) / np.linalg.det(screen)))
        center = np.array([view.fx * x / z + view.cx, view.fy * y / z + view.cy])
        ellipses.append((z, center, np.linalg.inv(screen), opacity, rgb, index))
    ellipses.sort(key=lambda ellipse: ellipse[0])
    image = np.zeros((5, view.height, view.width))
    weights = np.zeros((len(splats), view.height, view.width))
    for row in range(view.height):
        for column in range(view.width):
            passed, colour, depth = 1.0, np.zeros(3), 0.0
            for z, center, conic, opacity, rgb, index in ellipses:
                delta = np.array([column + 0.5, row + 0.5]) - center
                alpha = min(0.99, opacity * math.exp(-0.5 * delta @ conic @ delta))
                if alpha < 1 / 255:
                    continue
                if passed * (1 - alpha) <= 1e-4:
                    break
                weights[index, row, column] = passed * alpha
                colour += passed * alpha * rgb
                depth += passed * alpha * z
                passed *= 1 - alpha
            image[:, row, column] = *colour, 1 - passed, depth
    return image, weights


@pytest.mark.parametrize(
    ("time", "antialiased", "coefficients"),
    [(0.0, False, 4), (0.4, False, 4), (1.0, False, 4), (0.4, True, 4), (0.0, False, 6), (1.0, True, 6)],
)
def test_everything_drawn_is_as_specified(time: float, antialiased: bool, coefficients: int) -> None:
    static, dynamic, view = static_splats(60), dynamic_splats(40, coefficients=coefficients), camera()
    if antialiased:
        static.log_scales.sub_(2)
    image, weights = draw_pixel_by_pixel(static, dynamic, view, time, antialiased)
    render = rasterize_reference(static, dynamic, View(view, time, antialiased=antialiased, depth=True))
    assert render.depth is not None
    np.testing.assert_allclose(render.rgb.numpy(), image[:3], atol=1e-12)
    np.testing.assert_allclose(render.alpha.numpy(), image[3], atol=1e-12)
    np.testing.assert_allclose(render.depth.numpy(), image[4], atol=1e-11)
    weighed = contributions_reference(static, dynamic, View(view, time, antialiased=antialiased))
    np.testing.assert_allclose(weighed.total, weights.sum((1, 2)), rtol=1e-6)
    np.testing.assert_allclose(weighed.peak, weights.max((1, 2)), rtol=1e-6)


def test_depth_is_only_drawn_when_asked_for() -> None:
    assert rasterize_reference(static_splats(5), None, View(camera())).depth is None


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


def test_gradient_sets_leave_the_other_set_alone() -> None:
    static = static_splats(20).map(lambda a: a.requires_grad_())
    dynamic = dynamic_splats(20).map(lambda a: a.requires_grad_())
    rasterize_reference(static, dynamic, View(camera(), 0.4, gradients="dynamic")).rgb.sum().backward()
    assert static.means.grad is None
    assert dynamic.motion.grad is not None


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
    assert (statistics.pull_sum[~seen] == 0).all()
