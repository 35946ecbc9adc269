"""Places that given depths of one camera hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.points.still_depths import StillDepths
from hgs_core.scene.camera import Camera
from tests.walking_body import CAMERAS

CAMERA = CAMERAS[1]
ROWS, COLUMNS = (place.ravel() for place in np.mgrid[0 : CAMERA.height : 7, 0 : CAMERA.width : 7])
NORMAL = np.array((0.0, -0.8, 0.6))
LEVEL = -1.5  # distance of the plane from the world's origin


def rays(camera: Camera = CAMERA) -> np.ndarray:
    return camera.rays(np.stack([COLUMNS + 0.5, ROWS + 0.5], 1))


def plane_depths() -> np.ndarray:
    """Depths [H, W] of a plane in the camera's picture, 0 where it is behind it."""
    row, column = (place.ravel() for place in np.mgrid[0 : CAMERA.height, 0 : CAMERA.width])
    depths = (LEVEL - CAMERA.position @ NORMAL) / (CAMERA.rays(np.stack([column + 0.5, row + 0.5], 1)) @ NORMAL)
    return np.where(depths > 0, depths, 0).astype(np.float32).reshape(CAMERA.height, CAMERA.width)


def test_a_plane_has_its_normal_and_nothing_is_said_of_other_cameras() -> None:
    given = StillDepths({CAMERA.name: plane_depths()})
    depths, normals = given.at(CAMERA, ROWS, COLUMNS)
    known = depths > 0
    assert known.mean() > 0.3
    places = CAMERA.position + rays() * depths[:, None]
    np.testing.assert_allclose(places[known] @ NORMAL, LEVEL, atol=1e-4)
    inner = known & (plane_depths()[np.minimum(ROWS + 4, CAMERA.height - 1), COLUMNS] > 0)
    inner &= plane_depths()[np.maximum(ROWS - 4, 0), COLUMNS] > 0
    assert np.median(np.abs(normals[inner] @ NORMAL)) == pytest.approx(1.0, abs=1e-4)
    assert not given.at(CAMERAS[0], ROWS, COLUMNS)[0].any()


def test_edges_face_their_camera() -> None:
    depths = np.full((CAMERA.height, CAMERA.width), 2.0, np.float32)
    depths[:, 100:] = 4.0
    _, normals = StillDepths({CAMERA.name: depths}).at(CAMERA, np.array([50, 50]), np.array([60, 99]))
    flat, edge = np.abs(normals @ CAMERA.world_to_camera[2, :3])
    assert flat == pytest.approx(1.0)
    ray = CAMERA.rays(np.array([[99.5, 50.5]]))[0]
    assert np.abs(normals[1] @ ray) == pytest.approx(np.linalg.norm(ray))
    assert edge < 0.999


def test_points_move_along_their_rays_but_hidden_and_unseen_ones_have_no_place() -> None:
    depths = np.full((CAMERA.height, CAMERA.width), 2.0, np.float32)
    depths[:, 200:] = 0
    pixels = np.array([[60.5, 50.5], [60.5, 50.5], [60.5, 50.5], [250.5, 50.5], [-40.0, 50.5]])
    own = np.array([1.2, 2.1, 3.0, 1.2, 1.2])  # nearer, close behind, hidden, unknown, beside the picture
    found = StillDepths({CAMERA.name: depths}).held(
        [CAMERAS[0], CAMERA], CAMERA.position + CAMERA.rays(pixels) * own[:, None]
    )
    assert found.rows.tolist() == [0, 1]
    np.testing.assert_allclose(found.xyz, CAMERA.position + CAMERA.rays(pixels[:2]) * 2.0, atol=1e-6)
    assert found.normals.shape == (2, 3)


def test_they_are_kept_on_disk(tmp_path: Path) -> None:
    file = tmp_path / "depths.npz"
    assert StillDepths.load(file) is None
    StillDepths({"file": plane_depths(), "b/c": plane_depths()[:3]}).save(file)
    found = StillDepths.load(file)
    assert found is not None
    np.testing.assert_array_equal(found.maps["file"], plane_depths())
    np.testing.assert_array_equal(found.maps["b/c"], plane_depths()[:3])


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    file = tmp_path / "depths.npz"
    file.write_bytes(b"PK")
    with pytest.raises(InputError, match=r"depths\.npz: no readable depths"):
        StillDepths.load(file)
