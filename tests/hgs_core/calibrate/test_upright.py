"""The placement of a solution, against a rig of known up, size and middle."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.calibrate.structure import Solution, SolvedCamera
from hgs_core.calibrate.upright import Distance, placed
from hgs_core.scene.camera import looking_at


def solution(turned: bool = True) -> Solution:
    """Eight level cameras, 2 above the point that they look at and 5 from it, in a frame of its own."""
    numbers = np.random.default_rng(1)
    turn = np.linalg.qr(numbers.normal(size=(3, 3)))[0] if turned else np.eye(3)
    turn *= np.sign(np.linalg.det(turn))
    cameras = []
    for number in range(8):
        angle = number * np.pi / 4
        pose = looking_at([5 * np.sin(angle), -2.0, 5 * np.cos(angle)], [0, 0, 0])
        moved = np.eye(4)
        moved[:3, :3] = pose[:3, :3] @ turn.T
        moved[:3, 3] = 0.3 * pose[:3, 3] - moved[:3, :3] @ np.array([4.0, 5.0, 6.0])
        cameras.append(SolvedCamera(f"cam{number:02d}", 640, 480, "SIMPLE_RADIAL", (600, 320, 240, 0), moved, 100))
    return Solution(tuple(cameras), np.array([[4.0, 5.0, 6.0]]), 0.4)


def centres(found: Solution) -> np.ndarray:
    return np.array([-c.world_to_camera[:3, :3].T @ c.world_to_camera[:3, 3] for c in found.cameras])


def test_down_is_y_and_the_origin_is_where_the_cameras_look() -> None:
    found = placed(solution())
    height, across = centres(found)[:, 1], np.linalg.norm(centres(found)[:, ::2], axis=1)
    np.testing.assert_allclose(height / across, -2 / 5, atol=1e-9)
    assert np.ptp(height) < 1e-9
    np.testing.assert_allclose(found.points, 0, atol=1e-9)
    assert np.linalg.norm(centres(found), axis=1).mean() == pytest.approx(1.0)


def test_a_distance_gives_the_scale() -> None:
    found = centres(placed(solution(), distance=Distance("cam00", "cam04", 10.0)))
    assert np.linalg.norm(found[0] - found[4]) == pytest.approx(10.0)
    np.testing.assert_allclose(found[:, 1], -2.0)


def test_a_camera_tells_what_is_up() -> None:
    found = placed(solution(), up="cam03")
    np.testing.assert_allclose(found.cameras[3].world_to_camera[1, :3], [0, 1, 0], atol=1e-9)


def test_rotations_stay_rotations() -> None:
    for camera in placed(solution()).cameras:
        turn = camera.world_to_camera[:3, :3]
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("up", "distance"),
    [("cam99", None), (None, Distance("cam00", "cam99", 1.0)), (None, Distance("cam00", "cam00", 1.0))],
)
def test_cameras_that_are_not_there_are_named(up: str | None, distance: Distance | None) -> None:
    with pytest.raises(InputError, match=r"cam99|stand at one place"):
        placed(solution(), up, distance)


def test_a_metric_solution_stays_as_large_as_it_is() -> None:
    before, after = centres(solution()), centres(placed(solution(), metric=True))
    assert np.linalg.norm(after[0] - after[3]) == pytest.approx(np.linalg.norm(before[0] - before[3]))
