"""What is not a camera is refused."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera


@pytest.mark.parametrize(
    ("rotation", "complaint"),
    [
        (1.01 * np.eye(3), "not orthonormal"),
        (1e300 * np.ones((3, 3)), "not orthonormal"),  # whose products overflow
        (np.diag([1.0, 1.0, -1.0]), "reflection"),
        (np.full((3, 3), np.nan), "not a finite 4x4 matrix"),
    ],
)
def test_poses_that_do_not_rotate_are_refused(rotation: np.ndarray, complaint: str) -> None:
    pose = np.eye(4)
    pose[:3, :3] = rotation
    with pytest.raises(InputError, match=complaint):
        Camera("c", 64, 48, 50.0, 50.0, 32.0, 24.0, pose)


@pytest.mark.parametrize("name", ["width", "height"])
def test_a_size_that_is_no_number_is_refused(name: str) -> None:
    value = Camera("cam00", 64, 48, 50.0, 50.0, 32.0, 24.0, np.eye(4)).to_json()
    with pytest.raises(InputError, match="camera: unreadable"):
        Camera.from_json({**value, name: float("inf")})
