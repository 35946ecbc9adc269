"""Every way in which a rig's matrices can be meant, with two cameras swapped and one late: named, and cured."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cache
from itertools import product
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.cameras.rigid_poses import MIRROR
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check import poses_by_motion
from hgs_core.check.findings import Finding
from hgs_core.check.left_handed import judge_left_handed
from hgs_core.check.poses_by_motion import judge_by_motion
from hgs_core.check.silhouettes import Silhouette, silhouettes_of
from hgs_core.scene.camera import Camera
from tests.walking_body import CAMERAS, body, mask_of

LATE = 30  # frames

Mask = npt.NDArray[np.bool_]
Pose = npt.NDArray[np.float64]
Stored = list[tuple[Camera, Pose]]
"""Lenses with names, and matrices, perhaps reflections."""


class Case(NamedTuple):
    """A rig as it is stored."""

    axes: tuple[float, float, float]  # signs of the cameras' right, down and forward
    mirrored: bool  # whether its world is left-handed
    inverse: bool
    swapped: bool  # whether the last two cameras have each other's calibration
    late: bool  # whether the second camera is

    def stored(self, cameras: Sequence[Camera]) -> Stored:
        """The calibration of right cameras."""
        found = [np.diag((*self.axes, 1.0)) @ camera.world_to_camera for camera in cameras]
        found = [pose @ MIRROR if self.mirrored else pose for pose in found]
        found = [np.linalg.inv(pose) if self.inverse else pose for pose in found]
        order = [0, 2, 1] if self.swapped else [0, 1, 2]
        return [
            (dataclasses.replace(cameras[source], name=camera.name), found[source])
            for source, camera in zip(order, cameras, strict=True)
        ]

    @property
    def wrong(self) -> bool:
        """Whether the poses are."""
        return self != Case((1.0, 1.0, 1.0), False, False, False, self.late)


class Filmed:
    """A capture of which only silhouettes are asked, each made once for all readings."""

    def __init__(self, cameras: Sequence[Camera], frames: int, mask: Callable[[int, int], Mask]) -> None:
        self.cameras, self.times = cameras, np.arange(frames) / 30
        self._silhouettes = cache(lambda camera, frame: silhouettes_of(mask(camera, frame), cameras[camera]))

    def judged(self, case: Case, stored: Stored, monkeypatch: pytest.MonkeyPatch) -> list[Finding]:
        """The findings on cameras as they are stored."""

        def shapes(_: Any, camera: int, frames: Sequence[int], size: Camera) -> tuple[list[list[Silhouette]], bool]:
            late = LATE if case.late and camera == 1 else 0
            return [self._silhouettes(camera, max(0, frame - late)) for frame in frames], True

        monkeypatch.setattr(poses_by_motion, "find_silhouettes", shapes)
        capture = cast(Capture, self)
        if np.linalg.det(stored[0][1][:3, :3]) > 0:
            return list(judge_by_motion(capture, with_poses(stored), {}, [None] * 3).findings)
        return judge_left_handed(capture, with_poses([(camera, pose @ MIRROR) for camera, pose in stored]), {})


def with_poses(stored: Stored) -> list[Camera]:
    return [dataclasses.replace(camera, world_to_camera=pose) for camera, pose in stored]


def cured(stored: Stored, findings: Sequence[Finding]) -> Stored:
    lenses = {camera.name: camera for camera, _ in stored}
    right = {one.name: one for finding in findings for one in finding.corrected}
    return [
        (dataclasses.replace(lenses[one.calibration], name=camera.name), one.world_to_camera)
        if (one := right.get(camera.name))
        else (camera, pose)
        for camera, pose in stored
    ]


def moves(poses: Sequence[Pose]) -> Pose:
    """Poses of the other cameras against the first one, [2, 4, 4]."""
    return np.asarray(np.array(poses[1:]) @ np.linalg.inv(poses[0]))


@pytest.fixture(scope="session")
def walking() -> Filmed:
    frames = 231
    return Filmed(CAMERAS, frames, lambda camera, frame: mask_of(CAMERAS[camera], body(frame / (frames - 1))))


@pytest.fixture(scope="session", params=[("1", "12", "23"), ("1", "5", "11")], ids="-".join)
def basketball(request: pytest.FixtureRequest) -> Filmed:
    capture = open_capture(request.getfixturevalue("test_data")("panoptic_basketball"))
    chosen = [capture.camera_index(name) for name in request.param]

    def mask(camera: int, frame: int) -> Mask:
        found = capture.mask(chosen[camera], frame)
        assert found is not None
        return found

    return Filmed([capture.cameras[index] for index in chosen], len(capture.times), mask)


def check(film: Filmed, case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = case.stored(film.cameras)
    findings = film.judged(case, stored, monkeypatch)
    if case.wrong:
        first = findings[0]
        assert (first.stops, first.cameras) == (True, ())
        assert "--fix-poses" in first.cure
        assert ("inverted" in first.problem) == case.inverse
        assert ("swapped" in first.problem) == case.swapped
        right = cured(stored, findings)
        assert [camera.fx for camera, _ in right] == [camera.fx for camera in film.cameras]
        np.testing.assert_allclose(
            moves([pose for _, pose in right]), moves([camera.world_to_camera for camera in film.cameras]), atol=1e-9
        )
    after = film.judged(case, cured(stored, findings), monkeypatch)
    named = [(finding.stops, finding.cameras, "hgs sync" in finding.cure) for finding in after]
    assert named == ([(False, (film.cameras[1].name,), True)] if case.late else [])


EVERY = [Case(signs, *rest) for signs in product((1.0, -1.0), repeat=3) for rest in product((False, True), repeat=4)]
FEW = [
    Case((1.0, 1.0, 1.0), True, True, False, False),  # Kinects' camera-to-world of a left-handed world
    Case((1.0, -1.0, 1.0), True, False, False, False),  # Unity's: in a level rig some cameras fit as they are
    Case((1.0, -1.0, -1.0), False, True, True, False),
    Case((-1.0, -1.0, -1.0), True, False, False, False),  # translations of the wrong sign
    Case((1.0, 1.0, -1.0), False, False, True, True),
    Case((1.0, 1.0, 1.0), False, False, False, True),
]


@pytest.mark.parametrize("case", FEW, ids=str)
def test_readings_of_a_walking_body_are_named_and_cured(
    walking: Filmed, case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    check(walking, case, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("case", FEW, ids=str)
def test_readings_of_real_cameras_far_apart_are_named_and_cured(
    basketball: Filmed, case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    check(basketball, case, monkeypatch)


@pytest.mark.slow
def test_every_reading_of_a_walking_body_is_named_and_cured(walking: Filmed, monkeypatch: pytest.MonkeyPatch) -> None:
    for case in EVERY:
        check(walking, case, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("basketball", [("1", "5", "11")], indirect=True, ids="-".join)
def test_every_reading_of_real_cameras_is_named_and_cured(basketball: Filmed, monkeypatch: pytest.MonkeyPatch) -> None:
    for case in EVERY:
        check(basketball, case, monkeypatch)
