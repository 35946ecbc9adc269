"""Cameras of PanopticSports captures: train_meta.json and test_meta.json, which name their pictures, too.

The files of the data released with Dynamic 3D Gaussians (Luiten et al., 3DV 2024) hold `w`, `h`, and per frame and
camera the intrinsics `k` [3, 3], the OpenCV world-to-camera `w2c` [4, 4], the picture `fn` under ims/ and the camera's
number `cam_id`. Published figures are those of the cameras of test_meta.json; not every copy of the data has them.
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.unreadable import unreadable

__all__ = ["PANOPTIC_SPORTS"]

_TRAIN_FILE, _TEST_FILE = "train_meta.json", "test_meta.json"
_FRAME_RATE = 30.0  # pictures per second of the Panoptic Studio's HD cameras; the layout does not store it
_FIELDS = ("k", "w2c", "fn", "cam_id")


def _read(capture: Path, file: Path) -> Rig:
    rig, test_file = Rig((file,), _cameras(file), _FRAME_RATE), capture / _TEST_FILE
    return _with_test_cameras(rig, test_file) if test_file.is_file() else rig


def _with_test_cameras(rig: Rig, file: Path) -> Rig:
    cameras = _cameras(file)
    names = [camera.names[0] for camera in cameras]
    for camera in rig.cameras:
        if camera.names[0] in names:
            problem = f"camera {camera.names[0]} is in {_TRAIN_FILE}, too"
            raise InputError(file, problem, "list every camera in one of the files")
    if not any(picture.is_file() for camera in cameras for picture in camera.pictures):
        return dataclasses.replace(rig, notes=(f"{_TEST_FILE} is left aside: its pictures are not there",))
    note = f"the cameras of {_TEST_FILE} belong to the capture; --hold-out {','.join(names)} keeps them for scores"
    return dataclasses.replace(rig, files=(*rig.files, file), cameras=[*rig.cameras, *cameras], notes=(note,))


def _cameras(file: Path) -> list[CalibratedCamera]:
    meta = _read_meta(file)
    for row in meta["fn"]:
        for name in row:
            if not isinstance(name, str) or Path(name).is_absolute() or ".." in Path(name).parts:
                raise InputError(file, f"fn names {name!r}, outside ims/", "give paths below ims/")
    return [_camera(file, meta, column) for column in range(len(meta["cam_id"][0]))]


def _read_meta(path: Path) -> dict[str, Any]:
    """Read one of the files and check its shape: every frame lists the same cameras in every field."""
    try:
        meta: Any = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise unreadable(path, error, "restore the file from its source") from error
    if not isinstance(meta, dict):
        raise InputError(path, f"holds a {type(meta).__name__}, not an object", "restore the file from its source")
    missing = [name for name in ("w", "h", *_FIELDS) if name not in meta]
    if missing:
        raise InputError(path, f"the field {missing[0]!r} is missing", "restore the file from its source")
    for name in ("w", "h"):
        if not isinstance(meta[name], int) or meta[name] < 1:
            raise InputError(path, f"{name} is {meta[name]!r}", "it is the width or height of the pictures in pixels")
    for name in _FIELDS:
        if not isinstance(meta[name], list) or not all(isinstance(row, list) for row in meta[name]):
            raise InputError(path, f"{name} is not a list with one list per frame", "restore the file from its source")
        if len(meta[name]) != len(meta["fn"]):
            problem = f"{name} has {counted(len(meta[name]), 'frame')} and fn has {len(meta['fn'])}"
            raise InputError(path, problem, "every field needs one entry per frame")
    if not meta["fn"] or not meta["fn"][0]:
        raise InputError(path, "fn lists no picture", "restore the file from its source")
    ids = meta["cam_id"][0]
    for frame, row in enumerate(meta["cam_id"]):
        if row != ids:
            odd = sorted({str(camera) for camera in ids} ^ {str(camera) for camera in row})
            problem = f"frame {frame} lists {counted(len(row), 'camera')} and frame 0 lists {len(ids)}"
            cure = f"every frame needs the same cameras in the same order (look at {', '.join(odd) or 'their order'})"
            raise InputError(path, problem, cure)
        for name in _FIELDS:
            if len(meta[name][frame]) != len(ids):
                entries, wanted = counted(len(meta[name][frame]), "entry", "entries"), counted(len(ids), "camera")
                problem = f"frame {frame} has {entries} in {name} for {wanted}"
                raise InputError(path, problem, "every camera needs one entry per frame")
    return meta


def _camera(path: Path, meta: dict[str, Any], column: int) -> CalibratedCamera:
    """Return the camera of a column, after a check that it stands still."""
    name = str(meta["cam_id"][0][column])
    where = f"{path}, camera {name}"
    try:
        k = np.array([row[column] for row in meta["k"]], np.float64)
        w2c = np.array([row[column] for row in meta["w2c"]], np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(where, f"k or w2c is not a matrix of numbers ({error})") from error
    if k.shape[1:] != (3, 3) or w2c.shape[1:] != (4, 4):
        raise InputError(where, f"k is {k.shape[1:]} and w2c is {w2c.shape[1:]}", "they are 3x3 and 4x4")
    for field, values in (("k", k), ("w2c", w2c)):
        bad = ~np.isfinite(values).all(axis=(1, 2))
        if bad.any():
            raise InputError(where, f"{field} of frame {int(bad.argmax())} holds NaN or infinity", "restore the poses")
        moved = np.abs(values - values[0]).max(axis=(1, 2)) > 1e-6 * (1.0 + np.abs(values[0]).max())
        if moved.any():
            cure = "only captures with fixed cameras are supported"
            raise InputError(where, f"{field} changes at frame {int(moved.argmax())}", cure)
    if abs(k[0, 0, 1]) > 1e-3 * k[0, 0, 0]:
        raise InputError(where, f"k has a skew of {k[0, 0, 1]}", "undistort the pictures to square axes")
    return CalibratedCamera(
        where,
        (name,),
        w2c[0],
        (float(k[0, 0, 0]), float(k[0, 1, 1])),
        (float(k[0, 0, 2]), float(k[0, 1, 2])),
        (float(meta["w"]), float(meta["h"])),
        pictures=tuple(path.parent / "ims" / row[column] for row in meta["fn"]),
        stamps=tuple(float(frame) for frame in range(len(meta["fn"]))),
    )


def _find(capture: Path) -> Path | None:
    return file if (file := capture / _TRAIN_FILE).is_file() else None


PANOPTIC_SPORTS = CameraFormat("PanopticSports", _TRAIN_FILE, _find, _read)
