from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.projection import rotation_matrices
from hgs_core.scene import Segment
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.initial_splats import initial_splats, scene_extent

CLOCK = Segment(1.0, 3.0, DynamicSplats.empty())


def points() -> PointCloud:
    """300 points, every fifth of them moving, at both ends of the clock."""
    r = np.random.default_rng(0)
    count = 300
    return PointCloud.at_rest(
        xyz=r.uniform(-1, 1, (count, 3)).astype(np.float32),
        rgb=r.uniform(0, 1, (count, 3)).astype(np.float32),
        times=r.choice([1.0, 3.0], count).astype(np.float32),
        dynamic=(np.arange(count) % 5 == 0).astype(np.float32),
        spacing=r.uniform(0.05, 0.2, count).astype(np.float32),
    )


def test_first_splats_stand_on_their_points_and_hand_over_between_frames() -> None:
    cloud = points()
    static, dynamic = initial_splats(cloud, CLOCK, sampled_frames=3)
    np.testing.assert_array_equal(static.means.numpy(), cloud.xyz[cloud.dynamic < 0.5])
    np.testing.assert_array_equal(dynamic.motion[:, 0].numpy(), cloud.xyz[cloud.dynamic >= 0.5])
    decay = torch.exp(-torch.exp(dynamic.time_log_precisions) * (0.75 / 2) ** 2)
    torch.testing.assert_close(decay, torch.full_like(decay, 0.5))


@pytest.mark.parametrize(("labels", "moving"), [("static", 0), ("dynamic", 300), ("auto", 60)])
def test_labels_can_be_forced(labels: str, moving: int) -> None:
    static, dynamic = initial_splats(points(), CLOCK, 2, labels)
    assert (len(static), len(dynamic)) == (300 - moving, moving)


def test_a_still_point_that_must_be_dynamic_lives_all_the_time() -> None:
    _, dynamic = initial_splats(points(), CLOCK, 2, "dynamic")
    still = torch.from_numpy(points().dynamic < 0.5)
    assert (dynamic.time_centers[still] == 0.5).all()
    fade = torch.exp(-torch.exp(dynamic.time_log_precisions[still]) * 0.25)
    assert float(fade.min()) > 0.8


def test_extent_is_the_camera_radius() -> None:
    positions = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 2, 0], [0, -2, 0]])
    assert scene_extent(positions) == pytest.approx(2.2)
    assert scene_extent(positions[:1]) == 1.0


def test_first_splats_are_round_as_large_as_their_points_are_apart_and_faint() -> None:
    cloud = points()
    static, dynamic = initial_splats(cloud, CLOCK, 2, opacity=0.1)
    moving = cloud.dynamic >= 0.5
    for splats, rows in ((static, ~moving), (dynamic, moving)):
        np.testing.assert_allclose(np.exp(splats.log_scales.numpy()), cloud.spacing[rows, None].repeat(3, 1), rtol=1e-5)
        torch.testing.assert_close(torch.sigmoid(splats.opacity_logits), torch.full((len(splats),), 0.1))
        np.testing.assert_array_equal(splats.rgb.numpy(), cloud.rgb[rows])


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, -0.8), (1, 0, 0), (0, -1, 0), (-0.48, 0.6, -0.64)])
def test_a_point_on_a_surface_becomes_a_disc_in_it(normal: tuple[float, float, float]) -> None:
    cloud = points()
    cloud.normal[:250] = normal
    for splats, rows in zip(initial_splats(cloud, CLOCK, 2), (cloud.dynamic < 0.5, cloud.dynamic >= 0.5), strict=True):
        quats = splats.quats if isinstance(splats, StaticSplats) else splats.rotation[:, 0]
        axes = rotation_matrices(quats)  # [N, 3, 3], an axis of the splat in each column
        sizes = torch.exp(splats.log_scales) / torch.from_numpy(cloud.spacing[rows])[:, None]
        known = torch.from_numpy(cloud.normal[rows].any(axis=1))
        torch.testing.assert_close(sizes[known], torch.tensor([1.0, 1.0, 0.1]).expand(int(known.sum()), 3))
        facing = (axes[known][:, :, 2] @ torch.tensor(normal, dtype=torch.float32)).abs()
        torch.testing.assert_close(facing, torch.ones_like(facing))
        torch.testing.assert_close(sizes[~known], torch.ones(int((~known).sum()), 3))


def test_motion_is_the_points_velocity_in_normalised_time() -> None:
    """The clock lasts two seconds: a metre in one of them is two in the segment."""
    cloud = points()
    cloud.velocity[:] = (1.0, 0.0, -0.5)
    _, dynamic = initial_splats(cloud, CLOCK, 2, coefficients=6)
    np.testing.assert_array_equal(dynamic.motion[:, 1].numpy(), np.broadcast_to([2.0, 0.0, -1.0], (60, 3)))
    assert dynamic.motion.shape == (60, 6, 3)
    assert not dynamic.motion[:, 2:].any()
    moments = cloud.times[cloud.dynamic >= 0.5]
    np.testing.assert_array_equal(dynamic.time_centers.numpy(), (moments - 1) / 2)
