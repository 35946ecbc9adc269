"""Cameras of PanopticSports captures: train_meta.json and test_meta.json, which name their pictures, too.

The files of the data released with Dynamic 3D Gaussians (Luiten et al., 3DV 2024) hold `w`, `h`, and per frame and
camera the intrinsics `k` [3, 3], the OpenCV world-to-camera `w2c` [4, 4], the picture `fn` under ims/ and the camera's
number `cam_id`. Published figures are those of the cameras of test_meta.json; not every copy of the data has them.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted, shown
from hgs_core.capture.cameras.rig import LARGEST, CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.cameras.steady_pose import differing, median_pose, rig_radius, same_pose, spread
from hgs_core.capture.files.named_files import find_named, otherwise_named, path_as_written
from hgs_core.capture.files.text_file import read_json

__all__ = ["PANOPTIC_SPORTS"]

_TRAIN_FILE, _TEST_FILE = "train_meta.json", "test_meta.json"
_FRAME_RATE = 30.0  # pictures per second of the Panoptic Studio's HD cameras; the layout does not store it
_MOST_NAMED = 12  # cameras that a message lists
_FIELDS = ("k", "w2c", "fn", "cam_id")


def _read(capture: Path, file: Path) -> Rig:
    cameras, notes = _cameras(file)
    rig, test_file = Rig((file,), cameras, _FRAME_RATE, tuple(notes)), capture / _TEST_FILE
    return _with_test_cameras(rig, test_file) if test_file.is_file() else rig


def _with_test_cameras(rig: Rig, file: Path) -> Rig:
    cameras, notes = _cameras(file)
    names = [camera.names[0] for camera in cameras]
    for camera in rig.cameras:
        if camera.names[0] in names:
            problem = f"camera {camera.names[0]} is in {_TRAIN_FILE}, too"
            raise InputError(file, problem, "list every camera in one of the files")
    if not any(picture.is_file() for camera in cameras for picture in camera.pictures):
        note = f"{_TEST_FILE} is left aside: its pictures are not there"
        return dataclasses.replace(rig, notes=(*rig.notes, note))
    note = f"the cameras of {_TEST_FILE} belong to the capture; --hold-out {','.join(names)} keeps them for scores"
    both = [*rig.cameras, *cameras]
    return dataclasses.replace(rig, files=(*rig.files, file), cameras=both, notes=(*rig.notes, note, *notes))


def _cameras(file: Path) -> tuple[list[CalibratedCamera], list[str]]:
    """Return the cameras, and notes on them."""
    meta = _read_meta(file)
    listed = [name for row in meta["fn"] for name in row]
    for name in listed:
        if not isinstance(name, str) or not name:
            raise InputError(file, f"fn names {shown(name)}", "it is the name of a picture below ims/")
    named = find_named(file.parent / "ims", listed)
    files = []
    for name, found in zip(listed, named.files, strict=True):
        if (there := found or path_as_written(file.parent / "ims", name)) is None:
            raise InputError(file, f"fn names {shown(name)}, outside ims/", "give paths below ims/")
        files.append(there)
    count = len(meta["cam_id"][0])
    cameras = [_camera(file, meta, column, tuple(files[column::count])) for column in range(count)]
    poses = [[np.array(row[column], np.float64) for row in meta["w2c"]] for column in range(count)]
    radius = rig_radius([own[0] for own in poses])
    for camera, own in zip(cameras, poses, strict=True):
        moved = next((frame for frame, pose in enumerate(own) if not same_pose(pose, own[0], radius)), None)
        if moved is not None:
            cure = "only captures with fixed cameras are supported: cut to the frames in which it stands"
            raise InputError(camera.where, f"w2c changes at frame {moved}", cure)
    differ = spread(poses, radius)
    notes = [differing(differ)] if differ else []
    standing = [
        dataclasses.replace(camera, world_to_camera=median_pose(own)) if differ else camera
        for camera, own in zip(cameras, poses, strict=True)
    ]
    return standing, [*notes, *otherwise_named(file.name, named)]


def _read_meta(path: Path) -> dict[str, Any]:
    """Read one of the files and check its shape: every frame lists the same cameras in every field."""
    meta: Any = read_json(path, "restore the file from its source")
    if not isinstance(meta, dict):
        raise InputError(path, f"holds a {type(meta).__name__}, not an object", "restore the file from its source")
    missing = [name for name in ("w", "h", *_FIELDS) if name not in meta]
    if missing:
        raise InputError(path, f"the field {missing[0]!r} is missing", "restore the file from its source")
    for name in ("w", "h"):
        if not isinstance(meta[name], int | float) or not 1 <= meta[name] <= LARGEST:
            cure = "it is the width or height of the pictures in pixels"
            raise InputError(path, f"{name} is {shown(meta[name])}", cure)
    for name in _FIELDS:
        if not isinstance(meta[name], list) or not all(isinstance(row, list) for row in meta[name]):
            raise InputError(path, f"{name} is not a list with one list per frame", "restore the file from its source")
    for name in _FIELDS:
        if len(meta[name]) != len(meta["fn"]):
            problem = f"{name} has {counted(len(meta[name]), 'frame')} and fn has {len(meta['fn'])}"
            raise InputError(path, problem, "every field needs one entry per frame")
    if not meta["fn"] or not meta["fn"][0]:
        raise InputError(path, "fn lists no picture", "restore the file from its source")
    ids = meta["cam_id"][0]
    for camera in ids:
        if isinstance(camera, bool) or not isinstance(camera, int | str):
            raise InputError(path, f"cam_id holds {shown(camera)}", "it is the number or the name of a camera")
    for frame, row in enumerate(meta["cam_id"]):
        if row != ids:
            odd = sorted({str(camera) for camera in ids} ^ {str(camera) for camera in row})
            problem = f"frame {frame} lists {counted(len(row), 'camera')} and frame 0 lists {len(ids)}"
            look = ", ".join(odd[:_MOST_NAMED]) or "their order"
            cure = f"every frame needs the same cameras in the same order (look at {look})"
            raise InputError(path, problem, cure)
        for name in _FIELDS:
            if len(meta[name][frame]) != len(ids):
                entries, wanted = counted(len(meta[name][frame]), "entry", "entries"), counted(len(ids), "camera")
                problem = f"frame {frame} has {entries} in {name} for {wanted}"
                raise InputError(path, problem, "every camera needs one entry per frame")
    return meta


def _camera(path: Path, meta: dict[str, Any], column: int, pictures: tuple[Path, ...]) -> CalibratedCamera:
    """Return the camera of a column, after a check that it stands still."""
    name = str(meta["cam_id"][0][column])
    where = f"{path}, camera {name}"
    try:
        k = np.array([row[column] for row in meta["k"]], np.float64)
        w2c = np.array([row[column] for row in meta["w2c"]], np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        problem = f"k or w2c is not a matrix of numbers ({shown(str(error))})"
        raise InputError(where, problem, "they are 3x3 and 4x4 matrices, one for each frame") from error
    if k.shape[1:] != (3, 3) or w2c.shape[1:] != (4, 4):
        raise InputError(where, f"k is {k.shape[1:]} and w2c is {w2c.shape[1:]}", "they are 3x3 and 4x4")
    for field, values in (("k", k), ("w2c", w2c)):
        bad = ~(np.abs(values) < LARGEST).all(axis=(1, 2))
        if bad.any():
            problem = f"{field} of frame {int(bad.argmax())} holds NaN, infinity or more than 1e30"
            raise InputError(where, problem, "restore the poses")
    moved = np.abs(k - k[0]).max(axis=(1, 2)) > 1e-6 * (1.0 + np.abs(k[0]).max())
    if moved.any():
        cure = "only lenses that do not zoom are supported: cut to the frames in which they are alike"
        raise InputError(where, f"k changes at frame {int(moved.argmax())}", cure)
    if abs(k[0, 0, 1]) > 1e-3 * k[0, 0, 0]:
        raise InputError(where, f"k has a skew of {k[0, 0, 1]}", "undistort the pictures to square axes")
    return CalibratedCamera(
        where,
        (name,),
        w2c[0],
        (float(k[0, 0, 0]), float(k[0, 1, 1])),
        (float(k[0, 0, 2]), float(k[0, 1, 2])),
        (float(meta["w"]), float(meta["h"])),
        pictures=pictures,
        stamps=tuple(float(frame) for frame in range(len(pictures))),
    )


def _find(capture: Path) -> Path | None:
    return file if (file := capture / _TRAIN_FILE).is_file() else None


PANOPTIC_SPORTS = CameraFormat("PanopticSports", _TRAIN_FILE, _find, _read)
