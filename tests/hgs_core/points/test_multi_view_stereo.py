"""Multi-view stereo, on pictures of a wall that is blank but for dots."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.depth_map import GivenDepth, SweptPoints
from hgs_core.points.multi_view_stereo import multi_view_stereo
from hgs_core.scene.camera import Camera

WALL = 3.0
WIDTH, HEIGHT = 64, 48


def view(x: float, y: float) -> Camera:
    pose = np.eye(4)
    pose[:3, 3] = (-x, -y, 0)
    return Camera(f"{x} {y}", WIDTH, HEIGHT, 60, 60, WIDTH / 2, HEIGHT / 2, pose)


DOTS = np.random.default_rng(1).uniform(-2.5, 2.5, (120, 2))


def photograph(camera: Camera) -> np.ndarray:
    """Ray-cast the wall z = 3, grey with dark dots, at pixel centres."""
    row, column = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    x = (column - camera.cx) / camera.fx * WALL + camera.position[0]
    y = (row - camera.cy) / camera.fy * WALL + camera.position[1]
    nearest = np.sqrt(((np.stack([x, y], 2)[:, :, None] - DOTS) ** 2).sum(3)).min(2)
    brightness = 60 + 120 * np.clip((nearest - 0.04) / 0.04, 0, 1)
    return np.repeat(brightness.round().astype(np.uint8)[:, :, None], 3, 2)


CAMERAS = [view(x, y) for x in (-0.3, 0.3) for y in (-0.3, 0.3)]
EVERYWHERE = [np.ones((HEIGHT, WIDTH), bool)] * len(CAMERAS)
RANGES = [(1.0, 10.0)] * len(CAMERAS)


def stereo(wanted: list[np.ndarray] = EVERYWHERE) -> SweptPoints:
    return multi_view_stereo(CAMERAS, [photograph(camera) for camera in CAMERAS], wanted, RANGES)


@pytest.fixture(scope="module")
def points() -> SweptPoints:
    return stereo()


def test_the_wall_is_found_also_where_it_is_blank(points: SweptPoints) -> None:
    points = points.take(points.facing > 0)
    assert len(points.xyz) > 0.85 * len(CAMERAS) * WIDTH * HEIGHT
    assert (np.abs(points.xyz[:, 2] / WALL - 1) < 0.02).mean() > 0.97


def test_only_what_other_views_confirm_counts(points: SweptPoints) -> None:
    points = points.take(points.facing > 0)
    assert points.agreeing.min() >= 1
    assert (points.agreeing >= points.facing / 3).all()
    assert (points.opposed * 3 <= points.agreeing).all()


def test_surfaces_go_on_where_one_camera_looks_alone(points: SweptPoints) -> None:
    """The outer corner of each picture, 12x12 pixels, is seen by no other camera."""
    alone = points.take(points.facing == 0)
    assert len(CAMERAS) * 100 < len(alone.xyz) <= len(CAMERAS) * 144
    assert (np.abs(alone.xyz[:, :2]) > (1.3, 0.9)).all()
    assert np.median(np.abs(alone.xyz[:, 2] / WALL - 1)) < 0.02


def test_without_that_every_point_is_confirmed(points: SweptPoints) -> None:
    pictures = [photograph(camera) for camera in CAMERAS]
    confirmed = multi_view_stereo(CAMERAS, pictures, EVERYWHERE, RANGES, continued=False)
    assert np.array_equal(confirmed.xyz, points.xyz[points.facing > 0])


def test_unwanted_pixels_have_no_points() -> None:
    wanted = [np.zeros((HEIGHT, WIDTH), bool) for _ in CAMERAS]
    for mask in wanted:
        mask[:, 24:] = True
    found = stereo(wanted)
    assert 0 < len(found.xyz) <= len(CAMERAS) * HEIGHT * 40
    assert found.xyz[:, 0].min() > min(camera.position[0] for camera in CAMERAS) - 0.5


def test_any_number_of_threads_gives_the_same_bits(points: SweptPoints, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HGS_THREADS", "3")
    assert np.array_equal(stereo().xyz, points.xyz)


def test_a_single_picture_shows_no_points() -> None:
    found = multi_view_stereo(CAMERAS[:1], [photograph(CAMERAS[0])], EVERYWHERE[:1], RANGES[:1])
    assert len(found.xyz) == 0


def test_large_pictures_are_reduced() -> None:
    cameras = [camera.scaled(5) for camera in CAMERAS[:2]]
    large = [photograph(camera).repeat(5, 0).repeat(5, 1) for camera in CAMERAS[:2]]
    found = multi_view_stereo(cameras, large, [np.ones(picture.shape[:2], bool) for picture in large], RANGES[:2])
    assert 10_000 < len(found.xyz) <= 2 * 61_000
    assert np.median(np.abs(found.xyz[:, 2] / WALL - 1)) < 0.01


def given_to_first(depths: np.ndarray) -> GivenDepth:
    """Depths of the first picture alone, at any size."""
    return lambda view, size: depths if view == 0 else None


def test_known_depths_take_the_place_of_those_found(points: SweptPoints) -> None:
    """Nearly at the wall, so that other pictures agree."""
    depths = np.full((HEIGHT, WIDTH), np.float32(WALL * 1.004))
    depths[:, :20] = 0
    pictures = [photograph(camera) for camera in CAMERAS]
    found = multi_view_stereo(CAMERAS, pictures, EVERYWHERE, RANGES, known=given_to_first(depths))
    exact = np.isclose(found.xyz[:, 2], WALL * 1.004, rtol=1e-6).sum()
    assert exact > 0.95 * HEIGHT * (WIDTH - 20)


def test_known_depths_that_other_pictures_see_through_are_left_out() -> None:
    depths = np.full((HEIGHT, WIDTH), np.float32(WALL / 2))
    pictures = [photograph(camera) for camera in CAMERAS]
    found = multi_view_stereo(CAMERAS, pictures, EVERYWHERE, RANGES, known=given_to_first(depths))
    seen_by_others = (found.xyz[:, 2] < 0.6 * WALL) & (found.facing > 0)
    assert seen_by_others.sum() < 0.01 * HEIGHT * WIDTH
