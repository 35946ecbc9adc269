"""The floor and the dome of a backdrop, held against points of both."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.points.backdrop import Backdrop, find_backdrop, load_backdrop, save_backdrop
from hgs_core.scene.camera import Camera
from tests.synthetic import ring_of_cameras
from tests.walking_body import CAMERAS, body

UP = (0.0, -0.8, 0.6)
BACKDROP = Backdrop((1.0, 2.0, 3.0), UP, 5.0)


def heights(xyz: np.ndarray) -> np.ndarray:
    return np.asarray((xyz - np.array(BACKDROP.centre)) @ np.array(UP))


@given(st.integers(0, 2**32 - 1))
def test_every_ray_from_inside_meets_the_surface_once(seed: int) -> None:
    random = np.random.default_rng(seed)
    eye = np.array(BACKDROP.centre) + 2.0 * np.array(UP) + random.uniform(-1, 1, 3)
    rays = random.normal(size=(50, 3))
    depths = BACKDROP.depths(eye, rays)
    met = eye + depths[:, None] * rays
    assert (depths > 0).all()
    away = np.linalg.norm(met - np.array(BACKDROP.centre), axis=1)
    on_floor, on_dome = np.abs(heights(met)) < 1e-9, np.abs(away - 5.0) < 1e-9
    assert (on_floor | on_dome).all()
    assert (heights(met) > -1e-9).all()
    assert (away < 5.0 + 1e-9).all()


@given(st.integers(0, 2**32 - 1))
def test_the_nearest_place_is_on_the_surface_and_no_other_is_nearer(seed: int) -> None:
    random = np.random.default_rng(seed)
    xyz = np.array(BACKDROP.centre) + random.uniform(-4, 4, (20, 3)) + 2.0 * np.array(UP)
    found, normals = BACKDROP.nearest(xyz)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    again, _ = BACKDROP.nearest(found)
    np.testing.assert_allclose(again, found, atol=1e-9)
    above = heights(xyz) > 0
    eye = np.array(BACKDROP.centre) + 1.0 * np.array(UP)
    rays = random.normal(size=(300, 3))
    surface = eye + BACKDROP.depths(eye, rays)[:, None] * rays
    nearest = np.linalg.norm(surface[None] - xyz[:, None], axis=2).min(1)
    assert (np.linalg.norm(found - xyz, axis=1) <= nearest + 1e-9)[above].all()


def test_the_normals_are_those_of_floor_and_dome() -> None:
    centre, side = np.array(BACKDROP.centre), BACKDROP.axes[0]
    _, (floor, dome) = BACKDROP.nearest(np.array([centre + side + 0.1 * np.array(UP), centre + 4.5 * np.array(UP)]))
    np.testing.assert_allclose(floor, UP)
    np.testing.assert_allclose(dome, UP)
    assert abs(BACKDROP.axes[0] @ BACKDROP.axes[1]) < 1e-12
    assert abs(BACKDROP.axes[0] @ np.array(UP)) < 1e-12


def stills(cameras: Sequence[Camera], backdrop: Backdrop) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pictures of a backdrop of smooth colours, all of them known."""
    found = []
    for camera in cameras:
        rows, columns = np.divmod(np.arange(camera.width * camera.height), camera.width)
        rays = camera.rays(np.stack([columns + 0.5, rows + 0.5], 1))
        places = camera.position + backdrop.depths(camera.position, rays)[:, None] * rays
        picture = (127 + 100 * np.sin(2 * places)).astype(np.uint8).reshape(camera.height, camera.width, 3)
        found.append((picture, np.ones(picture.shape[:2], np.bool_)))
    return found


MOVING = np.concatenate([body(second) for second in np.linspace(0, 1, 24)]).astype(np.float32)


def test_the_found_one_stands_around_the_cameras_on_the_floor_of_what_moves() -> None:
    dark = [(np.zeros((240, 320, 3), np.uint8), np.zeros((240, 320), np.bool_))] * 3
    wrong = np.array([[9.0, 7.0, 0.0]] * 2000, np.float32)  # outside of the ring
    found = find_backdrop(CAMERAS, dark, np.concatenate([MOVING, wrong]))
    np.testing.assert_allclose(found.up, (0, -1, 0), atol=1e-9)
    assert found.centre[1] == pytest.approx(0.55, abs=0.1)  # y points down; the body's lowest points
    away = max(float(np.linalg.norm(camera.position - np.array(found.centre))) for camera in CAMERAS)
    assert found.radius == pytest.approx(1.25 * away)  # no picture shows any of it


@pytest.mark.parametrize("radius", [4.0, 5.5])
def test_the_dome_stands_where_pictures_agree(radius: float) -> None:
    cameras = ring_of_cameras(3, 160, 120)
    first = find_backdrop(cameras, stills(cameras, Backdrop((0.0, 0.5, 0.0), (0.0, -1.0, 0.0), 9.0)), MOVING)
    true = dataclasses.replace(first, radius=radius)
    assert find_backdrop(cameras, stills(cameras, true), MOVING).radius == pytest.approx(radius, rel=0.05)


def test_nothing_that_moves_leaves_the_cameras_to_tell() -> None:
    dark = [(np.zeros((240, 320, 3), np.uint8), np.zeros((240, 320), np.bool_))] * 3
    assert find_backdrop(CAMERAS, dark, np.zeros((0, 3), np.float32)).radius > 2.5


def test_it_is_kept_on_disk(tmp_path: Path) -> None:
    file = tmp_path / "backdrop.json"
    assert load_backdrop(file) is None
    save_backdrop(file, BACKDROP)
    assert load_backdrop(file) == BACKDROP


@pytest.mark.parametrize("text", ["", "[]", '{"centre": [0, 0, 0], "up": "x", "radius": 1}', '{"up": [0, 1, 0]}'])
def test_a_damaged_file_is_named(tmp_path: Path, text: str) -> None:
    file = tmp_path / "backdrop.json"
    file.write_text(text)
    with pytest.raises(InputError, match=r"backdrop\.json: no readable backdrop"):
        load_backdrop(file)
