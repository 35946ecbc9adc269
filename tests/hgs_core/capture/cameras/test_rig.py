"""The base of readers of cameras: scaling to the footage, and rotations in both forms."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.rig import CalibratedCamera, finite, pose_of, rotation_matrix


def calibrated(size: tuple[float, float] | None) -> CalibratedCamera:
    return CalibratedCamera("file, camera a", ("a",), np.eye(4), (100.0, 110.0), (70.0, 40.0), size)


def test_a_camera_is_scaled_to_its_pictures() -> None:
    camera = calibrated((128, 96)).camera("a", 64, 48)
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (50, 55, 35, 20)


def test_without_a_size_the_pictures_are_as_calibrated() -> None:
    camera = calibrated(None).camera("a", 64, 48)
    assert (camera.fx, camera.cx) == (100, 70)


@pytest.mark.parametrize("size", [(1920.0, 1080.0), (1921.0, 1081.0)])
def test_sides_may_be_rounded(size: tuple[float, float]) -> None:
    assert calibrated(size).camera("a", 480, 270).width == 480


@pytest.mark.parametrize(
    ("size", "problem"),
    [
        (
            (1088.0, 1920.0),
            "for 1088x1920 pixels and the pictures have 1080x1920; scale pictures without",
        ),
        (
            (1920.0, 1080.0),
            "for 1920x1080 pixels and the pictures have 1080x1920; calibrate with .* upright",
        ),
        ((0.0, 10.0), "width and height are 0 and 10"),
    ],
)
def test_another_shape_is_refused(size: tuple[float, float], problem: str) -> None:
    """1088 for 1080 rows is an encoder's padding: eight rows are cut off there, and nothing is scaled."""
    with pytest.raises(InputError, match=f"file, camera a: .*{problem}"):
        calibrated(size).camera("a", 1080, 1920)


@pytest.mark.parametrize("vector", [(0.3, -0.5, 0.9), (0.0, 0.0, 0.0), (1e-12, 0.0, 0.0), (0.0, 3.1, 0.0)])
def test_a_vector_turns_as_pycolmap_has_it(vector: tuple[float, float, float]) -> None:
    """Independent reference: pycolmap's rotation of the same quaternion."""
    import pycolmap

    angle = float(np.linalg.norm(vector))
    axis = np.array(vector) / angle if angle else np.array([1.0, 0, 0])
    expected = pycolmap.Rotation3d(np.array([*np.sin(angle / 2) * axis, np.cos(angle / 2)])).matrix()
    np.testing.assert_allclose(rotation_matrix(vector, "R"), expected, atol=1e-12)
    np.testing.assert_allclose(rotation_matrix(expected, "R"), expected)
    np.testing.assert_allclose(rotation_matrix(np.reshape(vector, (3, 1)), "R"), expected, atol=1e-12)


@pytest.mark.parametrize("values", [[1, 2], [[1, 2], [3, 4]], "turned", [float("nan"), 0, 0]])
def test_other_rotations_are_refused(values: object) -> None:
    with pytest.raises(InputError, match="R: the rotation is"):
        rotation_matrix(values, "R")


def test_numbers_are_counted_and_finite() -> None:
    np.testing.assert_array_equal(pose_of(np.eye(3), [[1], [2], [3]], "x")[:3, 3], [1, 2, 3])
    for values in ([1, 2], [1, 2, float("inf")], ["a", 2, 3]):
        with pytest.raises(InputError, match="x: the place is"):
            finite(values, 3, "x", "the place")
