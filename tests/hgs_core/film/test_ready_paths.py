"""Paths made of a manifest: where they lead, and that they stay in the captured space."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.manifest import Manifest
from hgs_core.film.camera_path import CameraPath
from hgs_core.film.ready_paths import orbit_path, rig_path
from hgs_core.scene.camera import looking_at
from tests.studio_scene import small_manifest
from tests.synthetic import ring_of_cameras

SPACE = CapturedSpace((0.0, 0.0, -1.0), 0.8, (-0.2, 0.6), (2.0, 4.0))


def manifest(space: CapturedSpace | None) -> Manifest:
    made = small_manifest([], [(0.0, 2.0, [])])
    return dataclasses.replace(made, cameras=tuple(ring_of_cameras(3, 64, 48)), captured_space=space)


def azimuths(path: CameraPath, space: CapturedSpace) -> np.ndarray:  # type: ignore[type-arg]
    return np.array([space.place(key.position, (0, 0, 0), (0, -1, 0)).azimuth for key in path.keys])


def test_an_orbit_swings_within_the_captured_space() -> None:
    path = orbit_path(manifest(SPACE))
    assert (path.start, path.end) == (0.0, 2.0)
    found = azimuths(path, SPACE)
    first, limit = math.pi / 4, 0.8  # radians
    assert found.max() == pytest.approx(first + 0.8 * (limit - first))
    assert found.min() == pytest.approx(first - 0.8 * (limit + first))
    assert all(SPACE.holds(SPACE.place(key.position, (0, 0, 0), (0, -1, 0))) for key in path.keys)
    np.testing.assert_allclose(path.keys[0].position, path.keys[-1].position, atol=1e-12)


def test_it_turns_all_round_where_cameras_stand_so() -> None:
    around = dataclasses.replace(SPACE, azimuth=None)
    found = np.unwrap(azimuths(orbit_path(manifest(around)), around))
    assert found[-1] - found[0] == pytest.approx(2 * math.pi)


def test_it_swings_a_little_where_no_space_is_known() -> None:
    path = orbit_path(manifest(None))
    first = np.array(path.keys[0].position)
    positions = np.array([key.position for key in path.keys])
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 3.0)
    cosines = positions[:, [0, 2]] @ first[[0, 2]] / (first[[0, 2]] @ first[[0, 2]])
    assert math.degrees(math.acos(cosines.min())) == pytest.approx(20, abs=0.1)


def test_a_camera_above_the_centre_is_no_start_of_an_orbit() -> None:
    camera = dataclasses.replace(manifest(None).cameras[0], world_to_camera=looking_at((0, -3, 0), (0, 0, 1)))
    with pytest.raises(InputError, match="stands above or below"):
        orbit_path(dataclasses.replace(manifest(None), cameras=(camera,)))


def test_a_path_through_the_rig_begins_beside_its_widest_gap() -> None:
    made = manifest(None)
    shuffled = dataclasses.replace(made, cameras=tuple(made.cameras[i] for i in (1, 2, 0)))
    path = rig_path(shuffled)
    found = [key.position for key in path.keys]
    expected = [tuple(camera.position) for camera in made.cameras]
    assert np.allclose(found, expected) or np.allclose(found, expected[::-1])
    for one in path.keys:
        np.testing.assert_allclose(one.target, (0, 0, 0), atol=1e-9)


def test_a_scene_that_does_not_last_is_shown_for_ten_seconds() -> None:
    still = dataclasses.replace(manifest(SPACE), end=0.0)
    assert orbit_path(still).end == rig_path(still).end == 10.0


def test_a_single_camera_is_no_path() -> None:
    with pytest.raises(InputError, match="single camera"):
        rig_path(dataclasses.replace(manifest(None), cameras=manifest(None).cameras[:1]))
