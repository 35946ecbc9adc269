from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from hgs_core.capture.cameras.rigid_poses import MIRROR
from hgs_core.capture.capture import Capture
from hgs_core.check.epipolar import Pairs, Rig
from hgs_core.check.left_handed import as_stored, judge_left_handed
from hgs_core.scene.camera import Camera
from tests.rigs import dome, matches_of

STILL = cast(Capture, type("Still", (), {"times": np.zeros(1)})())


def mirrored(cameras: list[Camera], change: Callable[[Any], Any]) -> list[Camera]:
    """Cameras as they are opened of stored matrices, which are reflections."""
    found = []
    for camera in cameras:
        stored = change(camera.world_to_camera)
        assert np.linalg.det(stored[:3, :3]) < 0
        found.append(
            Camera(
                camera.name, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, stored @ MIRROR
            )
        )
    return found


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda pose: pose @ MIRROR, "the poses are of a left-handed world"),
        (lambda pose: np.linalg.inv(pose @ MIRROR), "inverted"),
        (lambda pose: np.diag((1.0, -1.0, 1.0, 1.0)) @ pose, "what is read as right is right, down is up"),
        (lambda pose: np.linalg.inv(np.diag((1.0, 1.0, -1.0, 1.0)) @ pose), "inverted"),
    ],
)
@pytest.mark.parametrize("count", [4, 8])
def test_features_tell_what_reflections_mean(change: Callable[[Any], Any], problem: str, count: int) -> None:
    cameras = dome(count)
    (finding,) = judge_left_handed(STILL, mirrored(cameras, change), matches_of(cameras))
    assert finding.stops
    assert "the poses of all cameras are reflections" in finding.problem
    assert problem in finding.problem
    assert "--fix-poses" in finding.cure
    true = Rig.of(cameras).poses
    found = np.array([one.world_to_camera for one in finding.corrected])
    np.testing.assert_allclose(found[1:] @ np.linalg.inv(found[0]), true[1:] @ np.linalg.inv(true[0]), atol=1e-9)


@pytest.mark.parametrize("some", [{}, {(0, 1): matches_of(dome(4))[0, 1]}])
def test_what_nothing_tells_stops_without_a_correction(some: Pairs) -> None:
    (finding,) = judge_left_handed(STILL, mirrored(dome(4), lambda pose: pose @ MIRROR), some)
    assert finding.stops
    assert finding.corrected == ()
    assert "export with right-handed axes" in finding.cure


def test_the_stored_rig_has_the_reflections() -> None:
    rig = Rig.of(dome(4))
    assert as_stored(rig).mirrored
    np.testing.assert_array_equal(as_stored(as_stored(rig)).poses, rig.poses)
