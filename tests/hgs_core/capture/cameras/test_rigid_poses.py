"""Scales and mirrors are taken out of poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.corrected_poses import CorrectedCamera, write_corrections
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts

Change = Callable[[int, Any], Any]


def capture_of(root: Path, change: Change) -> Path:
    frames = layouts.frames_of_videos()
    for number, frame in enumerate(frames):
        frame["transform_matrix"] = change(number, np.array(frame["transform_matrix"])).tolist()
    layouts.videos()(root)
    layouts.transforms(frames)(root)
    return root


def scaled(by: Callable[[int], float]) -> Change:
    def change(number: int, pose: Any) -> Any:
        pose[:3, :3] *= by(number)
        return pose

    return change


@pytest.mark.parametrize(("first", "last", "said"), [(1.7, 1.7, "1.7"), (0.01, 0.01, "0.01"), (20.0, 23.0, "20 to 23")])
def test_a_scale_is_taken_out_and_said(tmp_path: Path, first: float, last: float, said: str) -> None:
    opened = open_capture(capture_of(tmp_path, scaled(lambda number: first + (last - first) * number / 3)))
    for camera, true in zip(opened.cameras, layouts.truth(), strict=True):
        np.testing.assert_allclose(camera.world_to_camera, true.world_to_camera, atol=1e-9)
    assert f"the poses of 4 cameras have a scale of {said}, which is taken out" in opened.notes


def test_a_scaled_camera_shows_points_where_the_scaled_matrix_does(tmp_path: Path) -> None:
    """World to camera [s R | t] is [R | t / s], not [R | t]: EasyMocap's files hold both."""
    layouts.PICTURES["folders"](tmp_path)
    layouts.opencv_files(tmp_path)
    for camera in layouts.truth():
        file = tmp_path / "cameras" / f"{camera.name}.yml"
        turn = layouts.opencv_matrix(camera.world_to_camera[:3, :3])
        file.write_text(file.read_text().replace(turn, layouts.opencv_matrix(2 * camera.world_to_camera[:3, :3])))
    point = np.array([[0.2, 0.1, 0.3]])
    for found, true in zip(open_capture(tmp_path).cameras, layouts.truth(), strict=True):
        pose = true.world_to_camera.copy()
        x, y, z = 2 * pose[:3, :3] @ point[0] + pose[:3, 3]
        pixel, _ = found.project(point)
        np.testing.assert_allclose(pixel[0], [true.fx * x / z + true.cx, true.fy * y / z + true.cy])


def test_one_axis_that_is_scaled_is_refused(tmp_path: Path) -> None:
    def stretch(number: int, pose: Any) -> Any:
        pose[:3, 0] *= 1.5
        return pose

    with pytest.raises(
        InputError, match=r"frame 0: the rotation of its pose is none: its rows have the lengths 1\.5, 1, 1"
    ):
        open_capture(capture_of(tmp_path, stretch))


def mirror(number: int, pose: Any) -> Any:
    pose[2] *= -1
    return pose


def test_a_mirrored_world_is_read_with_x_turned_and_said(tmp_path: Path) -> None:
    found = open_capture(capture_of(tmp_path, mirror))
    assert found.mirrored
    assert any("left-handed world" in note for note in found.notes)
    poses = [np.array([camera.world_to_camera for camera in cameras]) for cameras in (found.cameras, layouts.truth())]
    moves = [own[1:] @ np.linalg.inv(own[0]) for own in poses]
    np.testing.assert_allclose(moves[0], moves[1], atol=1e-9)


def test_corrected_poses_of_a_mirrored_world_are_no_guess(tmp_path: Path) -> None:
    capture_of(tmp_path, mirror)
    right = [CorrectedCamera(camera.name, camera.world_to_camera, camera.name) for camera in layouts.truth()]
    write_corrections(tmp_path, "x was turned", right)
    found = open_capture(tmp_path)
    assert not found.mirrored
    assert not any("left-handed world" in note for note in found.notes)
    np.testing.assert_allclose(found.cameras[1].world_to_camera, right[1].world_to_camera, atol=1e-12)
    write_corrections(tmp_path, "x was turned", right[:2])
    with pytest.raises(InputError, match="does not correct all cameras"):
        open_capture(tmp_path)


def test_a_rig_of_which_some_cameras_are_mirrored_is_refused_by_their_names(tmp_path: Path) -> None:
    capture_of(tmp_path, lambda number, pose: mirror(number, pose) if number in (1, 2) else pose)
    with pytest.raises(InputError, match=r"2 of 4 poses are reflections.*frame 1; .*frame 2; export all poses"):
        open_capture(tmp_path)
