"""The hull of a body that three cameras far apart see, held against the body itself."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.points.hull_surface import PROOF, hull_surface, soft_masks, views_of_movers
from hgs_core.scene.camera import Camera
from tests.walking_body import CAMERAS, body, mask_of

PICTURES = [np.full((240, 320, 3), 60 * number, np.uint8) for number in (1, 2, 3)]
SECOND = 0.3
SEMIAXES = (0.15, 0.5, 0.2)
MIDDLE = body(SECOND).mean(0)


def masks(cameras: tuple[Camera, ...] = CAMERAS) -> list[np.ndarray]:
    return [mask_of(camera, body(SECOND)) for camera in cameras]


def distance_shares(xyz: np.ndarray) -> np.ndarray:
    """Distances from the middle of the egg, shares of its radius in that direction."""
    return np.asarray(np.linalg.norm((xyz - MIDDLE) / SEMIAXES, axis=1))


def test_places_move_where_all_views_that_show_them_say_so() -> None:
    places = np.stack([MIDDLE, MIDDLE + np.array((0.6, 0, 0)), MIDDLE + np.array((0, 0, 50.0))])
    inside, beside, beyond = views_of_movers(CAMERAS, masks(), places)
    assert (inside, beside) == (3, 0)
    assert beyond < PROOF


def test_the_surface_is_that_of_the_body_but_for_what_three_views_leave_open() -> None:
    found = hull_surface(CAMERAS, PICTURES, masks(), 1500)
    shares = distance_shares(found.xyz.astype(np.float64))
    assert 1500 <= len(found.xyz) < 8000
    assert np.quantile(shares, 0.02) > 0.85
    assert np.median(shares) < 1.35  # a hexagon around a circle
    assert (views_of_movers(CAMERAS, soft_masks(masks()), found.xyz) >= PROOF).mean() > 0.99


def test_points_have_the_colours_of_the_cameras_that_they_face() -> None:
    found = hull_surface(CAMERAS, PICTURES, masks(), 600)
    for number, camera in enumerate(CAMERAS):
        own = np.isclose(found.rgb[:, 0], PICTURES[number][0, 0, 0] / 255)
        assert own.any()
        towards = camera.position - found.xyz[own]
        towards /= np.linalg.norm(towards, axis=1)[:, None]
        np.testing.assert_allclose(found.towards[own], towards, atol=1e-4)


def test_feet_that_one_picture_alone_shows_stand_below_the_rest() -> None:
    short = tuple(dataclasses.replace(camera, height=125) for camera in CAMERAS[1:])  # cut off at the middle
    cameras = (CAMERAS[0], *short)
    cut = [mask[: camera.height] for camera, mask in zip(cameras, masks(), strict=True)]
    pictures = [picture[: camera.height] for camera, picture in zip(cameras, PICTURES, strict=True)]
    found = hull_surface(cameras, pictures, cut, 1500)
    low = found.xyz[found.xyz[:, 1] > MIDDLE[1] + 0.3]
    assert len(low) > 50
    aside = np.linalg.norm((low - MIDDLE)[:, [0, 2]], axis=1)
    assert np.quantile(aside, 0.95) < 0.35


def test_what_one_camera_alone_has_seen_gives_no_points() -> None:
    alone = [masks()[0], *(np.zeros_like(mask) for mask in masks()[1:])]
    assert len(hull_surface(CAMERAS, PICTURES, alone, 500).xyz) == 0


def egg_depths(camera: Camera) -> np.ndarray:
    """Depths [H, W] at which rays enter the egg, 0 where they miss it."""
    row, column = (place.ravel() for place in np.mgrid[0 : camera.height, 0 : camera.width])
    ray = camera.rays(np.stack([column + 0.5, row + 0.5], 1)) / SEMIAXES
    start = (camera.position - MIDDLE) / SEMIAXES
    a, b, c = (ray * ray).sum(1), ray @ start, start @ start - 1
    root = b * b - a * c
    depths = np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, 0)
    return np.asarray(depths.reshape(camera.height, camera.width).astype(np.float32))


def test_known_depths_come_before_the_hull() -> None:
    def known(view: int, size: Camera) -> np.ndarray | None:
        return egg_depths(size) if view == 0 else None

    found = hull_surface(CAMERAS, PICTURES, masks(), 1500, known)
    before = hull_surface(CAMERAS, PICTURES, masks(), 1500)
    own = np.isclose(before.rgb[:, 0], PICTURES[0][0, 0, 0] / 255)
    assert np.quantile(np.abs(distance_shares(before.xyz[own]) - 1), 0.8) > 0.05
    assert np.quantile(np.abs(distance_shares(found.xyz[own]) - 1), 0.8) < 0.01
    np.testing.assert_array_equal(found.xyz[~own], before.xyz[~own])


def test_known_depths_that_other_views_deny_count_for_nothing() -> None:
    far = hull_surface(CAMERAS, PICTURES, masks(), 600, lambda view, size: egg_depths(size) + np.float32(1.0))
    before = hull_surface(CAMERAS, PICTURES, masks(), 600)
    np.testing.assert_array_equal(far.xyz, before.xyz)
