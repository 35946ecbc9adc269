"""The PanopticSports layout: train_meta.json, ims/<camera>/FFFFFF.jpg, and optionally seg/<camera>/FFFFFF.png.

The layout of the data released with Dynamic 3D Gaussians (Luiten et al., 3DV 2024): `train_meta.json` holds `w`, `h`,
and per frame and camera the intrinsics `k` [3, 3], the OpenCV world-to-camera `w2c` [4, 4], the picture `fn` under ims/
and the camera's number `cam_id`. seg/ holds masks of what moves.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.layout import Layout, Outline
from hgs_core.capture.mask_files import MaskFiles, find_masks
from hgs_core.capture.picture import check_size, list_folder, read_picture
from hgs_core.capture.recording import Recording
from hgs_core.scene.camera import Camera

__all__ = ["META_FILE", "PANOPTIC_SPORTS", "load_panoptic"]

META_FILE = "train_meta.json"
_FRAME_RATE = 30.0  # pictures per second of the Panoptic Studio's HD cameras; the layout does not store it
_FIELDS = ("k", "w2c", "fn", "cam_id")


class _ImageFolders:
    """Frames as image files."""

    def __init__(self, cameras: list[Camera], files: list[list[Path]]) -> None:
        self._cameras = cameras
        self._files = files  # [camera][frame]

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], tuple[Neighbour, ...]]:
        return read_picture(self._files[camera][frame], self._cameras[camera]), ()


def load_panoptic(path: Path, masks: Path | None) -> Recording:
    """Read a capture in the PanopticSports layout; `masks` replaces its own folder seg/.

    Raises:
        InputError: train_meta.json is unreadable or inconsistent, a camera moves or has no picture for a frame, a
            file is missing, or the first picture of a camera has the wrong size. Damage inside later pictures shows at
            first use.
    """
    meta_path = path / META_FILE
    meta = _read_meta(meta_path)
    frames = len(meta["fn"])
    cameras = [_camera(meta_path, meta, column) for column in range(len(meta["cam_id"][0]))]
    files = [[str(meta["fn"][frame][column]) for frame in range(frames)] for column in range(len(cameras))]

    for name in (name for names in files for name in names):
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise InputError(meta_path, f"fn names {name!r}, outside ims/", "give paths below ims/")

    present: list[tuple[Path, int]] = []
    for camera, names in zip(cameras, files, strict=True):
        present += _require(path / "ims", names, camera, "picture")
        check_size(path / "ims" / names[0], camera)
    given = find_masks(masks, cameras, frames, required=True) if masks else _own_masks(path / "seg", cameras, files)
    pictures = [[path / "ims" / name for name in names] for names in files]
    times = np.arange(frames) / _FRAME_RATE
    return Recording(path, cameras, times, _ImageFolders(cameras, pictures), given, present, meta_path)


def _own_masks(folder: Path, cameras: list[Camera], files: list[list[str]]) -> MaskFiles:
    """Return the masks below seg/, which are called like the pictures below ims/."""
    given = {}
    for camera, names in zip(cameras, files, strict=True):
        mask_names = [str(Path(name).with_suffix(".png")) for name in names]
        if (folder / mask_names[0]).parent.is_dir():
            _require(folder, mask_names, camera, "mask")
            check_size(folder / mask_names[0], camera)
            given[camera.name] = [folder / name for name in mask_names]
    return MaskFiles(given, folder)


def _read_meta(path: Path) -> dict[str, Any]:
    """Read train_meta.json and check its shape: every frame lists the same cameras in every field."""
    try:
        meta: Any = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(path, f"unreadable ({error})", "restore the file from its source") from error
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


def _camera(path: Path, meta: dict[str, Any], column: int) -> Camera:
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
    fx, fy, cx, cy = k[0, 0, 0], k[0, 1, 1], k[0, 0, 2], k[0, 1, 2]
    try:
        return Camera(name, meta["w"], meta["h"], float(fx), float(fy), float(cx), float(cy), w2c[0])
    except InputError as error:
        raise InputError(where, error.problem, error.cure) from error


def _require(folder: Path, names: list[str], camera: Camera, kind: str) -> list[tuple[Path, int]]:
    """Return the paths and sizes of a camera's pictures or masks, one per frame, all of which must be there."""
    listings: dict[Path, dict[str, int]] = {}
    found = []
    for frame, name in enumerate(names):
        path = folder / name
        if path.parent not in listings:
            listings[path.parent] = list_folder(path.parent)
        size = listings[path.parent].get(path.name)
        if size is None:
            raise InputError(path, f"camera {camera.name} has no {kind} for frame {frame}", "restore the file")
        if size == 0:
            raise InputError(path, "the file is empty", "restore the file")
        found.append((path, size))
    return found


def _outline(path: Path) -> Outline:
    """Return the cameras and the length that train_meta.json lists."""
    meta = _read_meta(path / META_FILE)
    frames = len(meta["fn"])
    return Outline(tuple(str(camera) for camera in meta["cam_id"][0]), frames, frames / _FRAME_RATE)


PANOPTIC_SPORTS = Layout(
    "PanopticSports", f"{META_FILE}, ims/", lambda names: META_FILE in names, load_panoptic, _outline
)
