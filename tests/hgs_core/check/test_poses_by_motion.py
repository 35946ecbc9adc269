from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.capture import Capture
from hgs_core.check.epipolar import Pair
from hgs_core.check.findings import Finding
from hgs_core.check.poses_by_motion import PosesByMotion, judge_by_motion
from hgs_core.scene.camera import Camera
from tests.walking_body import CAMERAS, MOMENTS, body, mask_of

FRAMES = 10 * (MOMENTS - 1) + 1

Pose = npt.NDArray[np.float64]


class Filmed:
    """A capture of which only masks are asked."""

    def __init__(self, points: Callable[[float], Any], late: Sequence[int] = (0, 0, 0)) -> None:
        self.times = np.arange(FRAMES) / 30
        self._points, self._late = points, late

    def mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_]:
        second = max(0, frame - self._late[camera]) / (FRAMES - 1)
        return mask_of(CAMERAS[camera], self._points(second))


def with_poses(change: Callable[[int, Pose], Pose]) -> list[Camera]:
    return [
        dataclasses.replace(camera, world_to_camera=change(number, camera.world_to_camera))
        for number, camera in enumerate(CAMERAS)
    ]


def judged(
    cameras: Sequence[Camera] = CAMERAS,
    points: Callable[[float], Any] = body,
    late: Sequence[int] = (0, 0, 0),
    ahead: Sequence[float | None] = (None, None, None),
    pairs: dict[tuple[int, int], Pair] | None = None,
) -> PosesByMotion:
    return judge_by_motion(cast(Capture, Filmed(points, late)), cameras, pairs or {}, ahead)


def the_finding(found: PosesByMotion) -> Finding:
    (finding,) = found.findings
    return finding


def test_right_poses_have_no_finding_and_small_errors() -> None:
    found = judged()
    assert found.findings == ()
    assert found.judged == {0, 1, 2}
    assert max(error for error in found.errors if error is not None) < 2


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda _, pose: np.linalg.inv(pose), "the poses are inverted"),
        (lambda _, pose: np.diag((1.0, -1.0, -1.0, 1.0)) @ pose, "OpenGL's axes for OpenCV's"),
        (lambda number, pose: CAMERAS[(0, 2, 1)[number]].world_to_camera, "cam1 and cam2 are swapped"),
    ],
)
def test_mistakes_with_all_poses_are_named_and_stop(change: Callable[[int, Pose], Pose], problem: str) -> None:
    finding = the_finding(judged(with_poses(change)))
    assert finding.stops
    assert "from where the poses of all cameras say" in finding.problem
    assert problem in finding.problem


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (np.linalg.inv, "its pose is inverted"),
        (lambda pose: np.diag((-1.0, -1.0, 1.0, 1.0)) @ pose, "turned by 180 degrees"),
        (lambda pose: np.vstack((np.column_stack((pose[:3, :3], 100 * pose[:3, 3])), pose[3])), "in another unit"),
    ],
)
def test_mistakes_with_one_pose_name_its_camera(change: Callable[[Pose], Pose], problem: str) -> None:
    finding = the_finding(judged(with_poses(lambda number, pose: change(pose) if number == 1 else pose)))
    assert (finding.stops, finding.cameras) == (True, ("cam1",))
    assert problem in finding.problem


def test_a_late_camera_is_no_wrong_pose() -> None:
    finding = the_finding(judged(late=(0, 30, 0)))
    assert (finding.stops, finding.cameras) == (False, ("cam1",))
    assert "its frames are about 30 behind the others'" in finding.problem


def test_poses_that_no_usual_mistake_explains_do_not_stop() -> None:
    numbers = np.random.default_rng(5)

    def shaken(number: int, pose: Pose) -> Pose:
        turn = np.eye(4)
        turn[:3, :3] = np.linalg.qr(numbers.normal(size=(3, 3)))[0]
        turn[:3, :3] *= np.sign(np.linalg.det(turn[:3, :3]))
        return np.asarray(turn @ pose) if number else pose

    finding = the_finding(judged(with_poses(shaken)))
    assert not finding.stops
    assert "no usual mistake explains it" in finding.problem


def test_an_offset_that_silhouettes_refute_is_none() -> None:
    assert judged(ahead=(0.0, None, -10.0)).in_step == {2}
    assert judged(late=(0, 0, 20), ahead=(0.0, 0.0, -20.0)).in_step == frozenset()


def test_cameras_whose_features_match_are_not_asked() -> None:
    match = Pair(np.zeros((1, 2)), np.zeros((1, 2)), 30.0)
    assert judged(pairs={(0, 1): match, (1, 2): match, (0, 2): match}).errors == (None, None, None)
    found = judged(pairs={(0, 1): match, (1, 2): match})  # one partner of two has the first and the last
    assert [error is None for error in found.errors] == [False, True, False]


def nobody(second: float) -> npt.NDArray[np.float64]:
    return np.full((1, 3), 0.1)


def two_people(second: float) -> npt.NDArray[np.float64]:
    return np.vstack((body(second), body(second, side=-1.0)))


def giant(second: float) -> npt.NDArray[np.float64]:
    return np.asarray(body(second) * (1.0, 3.0, 1.0))  # head and feet are outside of every picture


def with_shadow(second: float) -> npt.NDArray[np.float64]:
    points = body(second)
    return np.vstack((points, points * (1.0, 0.0, 1.0) + (0.3, 0.6, 0.0)))  # flat, beside the feet


@pytest.mark.parametrize("points", [nobody, two_people, giant, with_shadow])
def test_right_poses_stop_for_nothing_that_people_do(points: Callable[[float], npt.NDArray[np.float64]]) -> None:
    assert judged(points=points).findings == ()
