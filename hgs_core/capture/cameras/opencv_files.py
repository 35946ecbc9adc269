"""Cameras in files of OpenCV's FileStorage, one for each camera and called like it: cam00.yml.

Each holds the matrix of the lens (`camera_matrix` or `K`), `distortion_coefficients` (or `D`), and the pose from the
world to the camera, `R` (a matrix, or the axis times the angle; also `rvec`) and `T` (also `t`, `tvec`); perhaps
`image_width` and `image_height`. OpenCV counts pixels from the centre of the first one; here it lies at 0.5.
"""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.calibration_toml import OPENCV_CENTRE
from hgs_core.capture.cameras.easymocap import EXTRI_FILE, INTRI_FILE
from hgs_core.capture.cameras.opencv_yaml import OpenCvYaml, is_opencv_yaml
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig, finite, pose_of, rotation_matrix
from hgs_core.capture.lenses.lens import PINHOLE, opencv_lens
from hgs_core.capture.pictures.picture import list_folder

__all__ = ["OPENCV_FILES"]

_OTHERS = (INTRI_FILE, EXTRI_FILE)
_FOLDERS = (".", "cameras", "calibration")
_MATRIX = ("camera_matrix", "cameraMatrix", "K", "intrinsic_matrix")
_DISTORTION = ("distortion_coefficients", "distCoeffs", "dist_coeffs", "D", "dist")
_ROTATION = ("R", "rotation_matrix", "rotation", "rvec")
_TRANSLATION = ("T", "t", "translation", "tvec")


def _read(capture: Path, file: Path) -> Rig:
    files = _candidates(file.parent)
    return Rig(tuple(files), [_camera(OpenCvYaml(one)) for one in files])


def _camera(file: OpenCvYaml) -> CalibratedCamera:
    where = str(file.file)
    k = finite(file.numbers(_field(file, _MATRIX)), 9, where, "the matrix of the lens").reshape(3, 3)
    lens = PINHOLE
    distortion = next((name for name in _DISTORTION if name in file), None)
    if distortion is not None:
        fisheye = "fisheye" in file and bool(file.numbers("fisheye")[0])
        try:
            lens = opencv_lens(file.numbers(distortion).reshape(-1).tolist(), fisheye)
        except ValueError as error:
            raise InputError(where, f"{distortion}: {error}", "undistort the pictures first") from error
    rotation = rotation_matrix(file.numbers(_field(file, _ROTATION)), f"{where}, rotation")
    pose = pose_of(rotation, file.numbers(_field(file, _TRANSLATION)), where)
    size = None
    if "image_width" in file and "image_height" in file:
        size = float(file.numbers("image_width")[0]), float(file.numbers("image_height")[0])
    centre = float(k[0, 2]) + OPENCV_CENTRE, float(k[1, 2]) + OPENCV_CENTRE
    return CalibratedCamera(where, (file.file.stem,), pose, (float(k[0, 0]), float(k[1, 1])), centre, size, lens)


def _field(file: OpenCvYaml, names: tuple[str, ...]) -> str:
    found = next((name for name in names if name in file), None)
    if found is None:
        raise InputError(file.file, f"there is no {names[0]}", f"add it; it may also be called {', '.join(names[1:])}")
    return found


def _candidates(folder: Path) -> list[Path]:
    names = sorted(name for name in list_folder(folder) if name.lower().endswith((".yml", ".yaml")))
    return [folder / name for name in names if name not in _OTHERS and is_opencv_yaml(folder / name)]


def _find(capture: Path) -> Path | None:
    return next((files[0] for name in _FOLDERS if (files := _candidates(capture / name))), None)


OPENCV_FILES = CameraFormat("OpenCV", "cameras/<camera>.yml", _find, _read)
