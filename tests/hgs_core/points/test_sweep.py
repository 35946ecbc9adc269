"""The plane sweep, on pictures of a textured wall at a known depth."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.depth_map import SweptPoints
from hgs_core.points.sweep import depth_ranges, sweep
from hgs_core.scene.camera import Camera

WALL = 3.0


def view(x: float, y: float) -> Camera:
    pose = np.eye(4)
    pose[:3, 3] = (-x, -y, 0)
    return Camera(f"{x} {y}", 96, 72, 90, 90, 48, 36, pose)


def photograph(camera: Camera) -> np.ndarray:
    """Ray-cast the wall z = 3, with smooth waves as colours, at pixel centres."""
    row, column = np.mgrid[0:72, 0:96] + 0.5
    x = (column - camera.cx) / camera.fx * WALL + camera.position[0]
    y = (row - camera.cy) / camera.fy * WALL + camera.position[1]
    waves = [np.sin(7 * x + 2 * np.sin(3 * y)), np.sin(9 * y + 2 * np.sin(5 * x)), np.sin(11 * (x - y))]
    return (128 + 100 * np.stack(waves, 2)).round().astype(np.uint8)


CAMERAS = [view(x, y) for x in (-0.3, 0, 0.3) for y in (-0.2, 0.2)]


@pytest.fixture(scope="module")
def swept() -> SweptPoints:
    everywhere = [np.ones((72, 96), bool)] * len(CAMERAS)
    return sweep(CAMERAS, [photograph(camera) for camera in CAMERAS], everywhere, [(1.0, 10.0)] * 6, 3000)


def test_the_wall_is_found_at_its_depth(swept: SweptPoints) -> None:
    assert 2000 < len(swept.xyz) < 8000
    assert np.median(np.abs(swept.xyz[:, 2] - WALL)) < 0.03
    assert (np.abs(swept.xyz[:, 2] - WALL) < 0.15).mean() > 0.9


def test_the_neighbours_confirm_true_depths(swept: SweptPoints) -> None:
    right = np.abs(swept.xyz[:, 2] - WALL) < 0.1
    assert swept.agreeing[right].mean() > 3
    assert swept.opposed[right].mean() < 0.5


def test_only_wanted_places_in_the_hull_get_points() -> None:
    wanted = [np.zeros((72, 96), bool) for _ in CAMERAS]
    wanted[0][:, 48:] = True
    upper = [np.broadcast_to(np.arange(72)[:, None] < 36, (72, 96)) for _ in CAMERAS]
    points = sweep(CAMERAS, [photograph(c) for c in CAMERAS], wanted, [(1.0, 10.0)] * 6, 500, upper)
    assert len(points.xyz) > 0
    assert CAMERAS[0].project(points.xyz)[0][:, 0].min() > 47
    above = np.mean([camera.project(points.xyz)[0][:, 1] < 36.5 for camera in CAMERAS], axis=0)
    assert (above > 0.6).all()
    everywhere = sweep(CAMERAS, [photograph(c) for c in CAMERAS], wanted, [(1.0, 10.0)] * 6, 500)
    assert len(everywhere.xyz) > len(points.xyz)


def test_a_single_picture_has_no_depths() -> None:
    everywhere = [np.ones((72, 96), bool)]
    assert len(sweep(CAMERAS[:1], [photograph(CAMERAS[0])], everywhere, [(1.0, 10.0)], 500).xyz) == 0


def test_depth_ranges_hold_the_points() -> None:
    points = np.random.default_rng(0).uniform((-1, -1, 2), (1, 1, 6), (200, 3))
    for near, far in depth_ranges(CAMERAS, points):
        assert 1.2 < near < 2.2
        assert 5.8 < far < 9


def test_a_cameras_own_lens_does_not_widen_its_range() -> None:
    points = np.random.default_rng(0).uniform((-1, -1, 2), (1, 1, 6), (200, 3))
    lens = CAMERAS[0].position + np.tile((0.0, 0.0, 0.01), (10, 1))
    near, _ = depth_ranges(CAMERAS, np.concatenate([points, lens]))[0]
    apart = [np.linalg.norm(camera.position - CAMERAS[0].position) for camera in CAMERAS[1:]]
    assert 0.4 * min(apart) < near < 0.5 * max(apart)


def test_what_is_before_the_cameras_stays_in_their_range() -> None:
    points = np.random.default_rng(0).uniform((-0.1, -0.1, 0.2), (0.1, 0.1, 0.22), (200, 3))
    assert all(near < 0.2 < 0.22 < far for near, far in depth_ranges(CAMERAS, points))


def test_without_points_there_is_still_a_range() -> None:
    assert all(0 < near < far for near, far in depth_ranges(CAMERAS, np.zeros((0, 3))))


def test_known_depths_take_the_place_of_those_found(swept: SweptPoints) -> None:
    """Twice as far, in the left half of the first picture."""
    depths = np.full((72, 96), np.float32(2 * WALL))
    depths[:, 48:] = 0
    wanted = [np.ones((72, 96), bool)] + [np.zeros((72, 96), bool)] * (len(CAMERAS) - 1)
    pictures = [photograph(camera) for camera in CAMERAS]
    ranges = [(1.0, 10.0)] * len(CAMERAS)
    points = sweep(CAMERAS, pictures, wanted, ranges, 500, known=lambda view, _: None if view else depths)
    left = CAMERAS[0].project(points.xyz)[0][:, 0] < 48
    np.testing.assert_allclose(points.xyz[left, 2], 2 * WALL, rtol=1e-6)
    assert np.abs(points.xyz[~left, 2] - WALL).max() < WALL / 2
