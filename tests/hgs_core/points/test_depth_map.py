"""Points of depth maps, and the votes of other views."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.depth_map import DepthMap, SweptPoints, points_of_maps
from hgs_core.scene.camera import Camera

WIDTH, HEIGHT = 12, 8


def view(x: float) -> Camera:
    pose = np.eye(4)
    pose[0, 3] = -x
    return Camera(str(x), WIDTH, HEIGHT, 10, 10, WIDTH / 2, HEIGHT / 2, pose)


CAMERAS = [view(0.0), view(0.2), view(50.0)]  # the last looks elsewhere
PICTURES = [np.full((HEIGHT, WIDTH, 3), shade, np.uint8) for shade in (51, 102, 153)]


def points(first: float, second: float, step: int = 1) -> SweptPoints:
    grid = (HEIGHT // step, WIDTH // step)
    maps = [DepthMap(step, np.full(grid, depth)) for depth in (first, second, 0.0)]
    return points_of_maps(CAMERAS, PICTURES, maps, agreement=0.02, beyond=1.1)


def test_points_lie_at_their_depths_behind_the_middle_of_their_pixels() -> None:
    first = points(3.0, 3.0).take(np.arange(HEIGHT * WIDTH))
    pixels, depths = CAMERAS[0].project(first.xyz)
    row, column = np.mgrid[0:HEIGHT, 0:WIDTH]
    np.testing.assert_allclose(depths, 3.0, rtol=1e-6)
    np.testing.assert_allclose(pixels, np.stack([column, row], 2).reshape(-1, 2) + 0.5, atol=1e-5)


def test_points_of_a_coarser_grid_lie_behind_its_pixels() -> None:
    first = points(3.0, 3.0, step=4).take(np.arange(6))
    np.testing.assert_allclose(CAMERAS[0].project(first.xyz)[0][:3], [[2.5, 2.5], [6.5, 2.5], [10.5, 2.5]], atol=1e-5)


def test_points_have_the_colours_of_their_own_pictures() -> None:
    np.testing.assert_allclose(np.unique(points(3.0, 3.0).rgb), [0.2, 0.4], rtol=1e-6)


@pytest.mark.parametrize(
    ("second", "agreeing", "opposed"), [(3.05, True, False), (3.2, False, False), (3.5, False, True)]
)
def test_other_views_agree_or_see_through(second: float, agreeing: bool, opposed: bool) -> None:
    first = points(3.0, second).take(np.arange(HEIGHT * WIDTH))
    facing = first.facing > 0
    assert 0 < facing.sum() < len(facing)  # the second camera stands beside the first; the third sees none
    assert first.facing.max() == 1
    assert (first.agreeing[facing] > 0).all() == agreeing
    assert (first.opposed[facing] > 0).all() == opposed
    assert not first.agreeing[~facing].any()
