"""Cameras of EasyMocap, EasyVolcap, 4K4D and their relatives: intri.yml and extri.yml.

For a camera called 00: `K_00` [3, 3], `dist_00` (or `D_00`) as OpenCV orders it, `Rot_00` [3, 3] or `R_00` (axis times
angle), `T_00`, from the world to the camera, and perhaps `H_00` and `W_00`, the size of the pictures.
"""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.opencv_yaml import OpenCvYaml
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig, finite, pose_of, rotation_matrix
from hgs_core.capture.lenses.lens import PINHOLE, opencv_lens

__all__ = ["EASYMOCAP", "EXTRI_FILE", "INTRI_FILE"]

INTRI_FILE, EXTRI_FILE = "intri.yml", "extri.yml"


def _read(capture: Path, file: Path) -> Rig:
    other = file.with_name(EXTRI_FILE)
    if not other.is_file():
        raise InputError(capture, f"there is {INTRI_FILE} but no {EXTRI_FILE}", "put the cameras' poses beside it")
    intri, extri = OpenCvYaml(file), OpenCvYaml(other)
    names = intri.words("names") or [name[2:] for name in intri.names if name.startswith("K_")]
    if not names:
        raise InputError(file, "lists no camera", "it has names, and K_NAME and dist_NAME for each of them")
    return Rig((file, other), [_camera(name, intri, extri) for name in names])


def _camera(name: str, intri: OpenCvYaml, extri: OpenCvYaml) -> CalibratedCamera:
    where = f"{intri.file}, camera {name}"
    k = finite(intri.numbers(f"K_{name}"), 9, where, f"K_{name}").reshape(3, 3)
    if abs(k[0, 1]) > 1e-3 * abs(k[0, 0]):
        raise InputError(where, f"K_{name} has a skew of {k[0, 1]:g}", "undistort the pictures to square axes")
    lens = PINHOLE
    for field in (f"dist_{name}", f"D_{name}"):
        if field in intri:
            try:
                lens = opencv_lens(intri.numbers(field).reshape(-1).tolist(), fisheye=False)
            except ValueError as error:
                raise InputError(where, f"{field}: {error}", "undistort the pictures first") from error
            break
    size = None
    if f"H_{name}" in intri and f"W_{name}" in intri:
        size = float(intri.numbers(f"W_{name}")[0]), float(intri.numbers(f"H_{name}")[0])
    field = f"Rot_{name}" if f"Rot_{name}" in extri else f"R_{name}"
    rotation = rotation_matrix(extri.numbers(field), f"{extri.file}, {field}")
    pose = pose_of(rotation, extri.numbers(f"T_{name}"), f"{extri.file}, T_{name}")
    centre = float(k[0, 2]), float(k[1, 2])
    return CalibratedCamera(where, (name,), pose, (float(k[0, 0]), float(k[1, 1])), centre, size, lens)


def _find(capture: Path) -> Path | None:
    return file if (file := capture / INTRI_FILE).is_file() else None


EASYMOCAP = CameraFormat("easymocap", f"{INTRI_FILE}, {EXTRI_FILE}", _find, _read)
