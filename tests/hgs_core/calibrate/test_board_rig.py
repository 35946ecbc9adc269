"""Five cameras and six moments of a rendered board: the cameras are known."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.calibrate.board import Sighting, find_board
from hgs_core.calibrate.board_rig import cameras_of_board
from hgs_core.calibrate.structure import Solution
from tests.hgs_core.calibrate.boards import BOARD, CAMERAS, FOCAL, FRAMES, HEIGHT, WIDTH, photograph, rig

pytest.importorskip("cv2")
NAMES = [camera.name for camera in rig()]


@pytest.fixture(scope="module")
def sightings() -> list[Sighting]:
    cameras = rig()
    return find_board(BOARD, CAMERAS, lambda camera, frame: photograph(cameras[camera], frame), FRAMES, silent)


def solved(sightings: list[Sighting], floor: bool = True) -> Solution:
    return cameras_of_board(Path("x"), NAMES, [(WIDTH, HEIGHT)] * CAMERAS, BOARD, sightings, floor=floor)


def test_cameras_stand_where_they_do_in_metres_above_the_floor(sightings: list[Sighting]) -> None:
    solution = solved(sightings)
    for found, true in zip(solution.cameras, rig(), strict=True):
        turn = found.world_to_camera[:3, :3]
        place = -turn.T @ found.world_to_camera[:3, 3]
        np.testing.assert_allclose(place, true.position, atol=0.03)  # 2 m away
        angle = np.degrees(np.arccos((np.trace(turn @ true.world_to_camera[:3, :3].T) - 1) / 2))
        assert angle < 0.2
        assert found.parameters[0] == pytest.approx(FOCAL, rel=0.02)
    assert solution.error < 0.4


def test_without_the_floor_the_scale_is_still_metres(sightings: list[Sighting]) -> None:
    cameras = solved(sightings, floor=False).cameras
    first, last = (-one.world_to_camera[:3, :3].T @ one.world_to_camera[:3, 3] for one in (cameras[0], cameras[-1]))
    true = np.linalg.norm(rig()[0].position - rig()[-1].position)
    assert np.linalg.norm(first - last) == pytest.approx(true, rel=0.01)


def test_a_camera_that_does_not_see_the_board_and_one_that_sees_it_alone_are_named(sightings: list[Sighting]) -> None:
    with pytest.raises(InputError, match="the board is not seen by cam3"):
        solved([one for one in sightings if one.camera != 3])
    alone = [one for one in sightings if (one.camera == 4) == (one.moment == 3)]
    with pytest.raises(InputError, match="cam4 never sees the board while the others do"):
        solved(alone)


def test_corners_that_fit_no_poses_are_refused(sightings: list[Sighting]) -> None:
    random = np.random.default_rng(0)
    shaken = [dataclasses.replace(one, xy=one.xy + random.normal(0, 12, one.xy.shape)) for one in sightings]
    with pytest.raises(InputError, match=r"leave \d+\.\d px on average"):
        solved(shaken)
