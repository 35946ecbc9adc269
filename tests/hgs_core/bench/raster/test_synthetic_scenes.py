"""The scenes of the benchmark have the statistics they promise; the references here are plain numpy."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.bench.raster.synthetic_scenes import bench_camera, bench_scene, bench_target, median_radius
from hgs_core.scene.splats import StaticSplats
from hgs_core.scene.temporal import evaluate


def radii(static: StaticSplats[np.ndarray]) -> np.ndarray:
    """Screen radius (3 sigma, major axis, without a low-pass) of every splat at 676x507, seen from afar."""
    camera = bench_camera(676, 507)
    R = camera.world_to_camera[:3, :3]
    _, z = camera.project(static.means)
    found = []
    for quat, log_scale, depth in zip(static.quats.astype(np.float64), static.log_scales, z, strict=True):
        w, *v = quat / np.linalg.norm(quat)
        cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        turn = np.eye(3) + 2 * w * cross + 2 * cross @ cross  # Rodrigues
        covariance = R @ turn @ np.diag(np.exp(2.0 * log_scale)) @ turn.T @ R.T
        found.append(3 * np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[1]) * camera.fx / depth)
    return np.array(found)


def test_one_seed_is_one_scene() -> None:
    first, again, other = bench_scene(200, 1, 0.3), bench_scene(200, 1, 0.3), bench_scene(200, 2, 0.3)
    for (_, a), (_, b) in zip(first.static.items(), again.static.items(), strict=True):
        np.testing.assert_array_equal(a, b)
    assert not np.array_equal(first.static.means, other.static.means)


@pytest.mark.parametrize(("splats", "radius"), [(20_000, 4.5), (100_000, 3.0), (500_000, 2.0)])
def test_more_splats_are_smaller(splats: int, radius: float) -> None:
    assert median_radius(splats) == pytest.approx(radius, rel=0.01)


def test_screen_radii_have_the_median_and_the_few_large_ones() -> None:
    scene = bench_scene(3000, 0)
    found = radii(scene.static) / median_radius(3000)
    assert np.median(found) == pytest.approx(1.0, rel=0.06)
    assert (found > 6).mean() == pytest.approx(0.02 * 0.8 + 0.98 * 0.0014, abs=0.008)


def test_most_splats_are_in_the_picture_and_some_beyond_it() -> None:
    camera = bench_camera(676, 507)
    pixels, depths = camera.project(bench_scene(3000, 0).static.means)
    inside = ((pixels > 0) & (pixels < (676, 507))).all(1)
    assert depths.min() > 1
    assert 0.8 < inside.mean() < 0.98


def test_opacities_have_two_modes() -> None:
    logits = bench_scene(5000, 0).static.opacity_logits
    counts, _ = np.histogram(1 / (1 + np.exp(-logits)), bins=5, range=(0, 1))
    assert counts[2] < counts[0]
    assert counts[2] < counts[4]


def test_neighbours_in_memory_are_neighbours_in_space() -> None:
    means = bench_scene(5000, 0).static.means
    shuffled = np.random.default_rng(0).permutation(means)

    def stride(points: np.ndarray) -> float:
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())

    assert stride(means) < 0.2 * stride(shuffled)


def test_share_of_dynamic_splats() -> None:
    scene = bench_scene(1000, 0, 0.25)
    assert scene.dynamic is not None
    assert (len(scene.static), len(scene.dynamic)) == (750, 250)
    _, _, opacities = evaluate(scene.dynamic, scene.time)
    assert 0.4 < (opacities >= 1 / 255).mean() < 0.6
    assert bench_scene(1000, 0).dynamic is None


def test_target_is_a_picture() -> None:
    target = bench_target(bench_camera(40, 24), 0)
    assert (target.shape, target.dtype) == ((3, 24, 40), np.float32)
    assert target.min() >= 0
    assert target.max() <= 1
    assert target.std() > 0.05
