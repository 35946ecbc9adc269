"""Cameras of instant-ngp and nerfstudio: transforms.json, or transforms_train.json and its like, which name pictures.

Intrinsics are `fl_x`, `fl_y` (or `camera_angle_x`), `cx`, `cy`, `w`, `h` and the distortion `k1`...`k4`, `p1`, `p2`,
for all pictures or in a frame of their own; per frame the picture `file_path`, perhaps its `time`, and
`transform_matrix` [4, 4], which is camera-to-world in the convention of OpenGL: x right, y up, z backwards.

Frames of one pose are the pictures of one fixed camera. Where all poses differ the pictures are photographs of one
moment, or, if their times differ, of one camera that moves, which is refused.
"""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.cameras.transforms_frame import camera_of_frame, number_of
from hgs_core.capture.footage import is_picture, is_video, natural_order
from hgs_core.capture.picture import list_folder, picture_size
from hgs_core.capture.unreadable import unreadable

__all__ = ["NERFSTUDIO", "TRANSFORMS_FILE"]

TRANSFORMS_FILE = "transforms.json"
_MOST_NAMED = 5  # pictures that a note names


@dataclass(frozen=True)
class _Frame:
    """One entry of `frames`."""

    where: str
    file: Path
    values: dict[str, Any]  # its own, and those of the whole file where it has none

    @property
    def time(self) -> float | None:
        return number_of(self.values, "time", self.where) if "time" in self.values else None

    @property
    def pose(self) -> str:
        """What frames of one camera share."""
        intrinsics = [self.values.get(name) for name in ("fl_x", "fl_y", "cx", "cy", "w", "h", "k1")]
        return json.dumps([np.round(np.array(self.values.get("transform_matrix"), np.float64), 6).tolist(), intrinsics])


def _read(capture: Path, file: Path) -> Rig:
    files = tuple(_files(capture))
    frames = [frame for one in files for frame in _frames(capture, one)]
    for frame in frames:
        camera_of_frame(frame.values, None, frame.where)  # so that poses are there before they are compared
    cameras: dict[str, list[_Frame]] = defaultdict(list)
    for frame in frames:
        cameras[frame.pose].append(frame)
    moments = {frame.time for frame in frames}
    if all(is_video(frame.file.name) or frame.file.is_dir() for frame in frames):
        return Rig(files, [_whole(frame) for frame in frames])
    if len(cameras) == len(frames):
        if len(moments) > 1 or file.name != TRANSFORMS_FILE:
            problem = f"its {len(frames)} frames are each from another place: one camera that moves (D-NeRF, Blender)"
            cure = (
                "HGS needs several cameras that stand still: one view of a moment leaves open what moves, and how far"
            )
            raise InputError(file, problem, f"{cure} away it is")
        if folders := _folders_of_one_listed(frames):
            return Rig(files, [_fixed(frame, (folder,)) for frame, folder in zip(frames, folders, strict=True)])
    if len(moments) > 1 or (len(cameras) < len(frames) and min(map(len, cameras.values())) > 1):
        return _videos(files, list(cameras.values()), moments)
    return _photographs(capture, files, frames)


def _photographs(capture: Path, files: tuple[Path, ...], frames: list[_Frame]) -> Rig:
    there = [frame for frame in frames if frame.file.is_file()]
    if not there:
        raise InputError(files[0], f"none of its {len(frames)} pictures is there", "restore the pictures")
    names = [frame.file.stem for frame in there]
    if len(set(names)) < len(names):
        names = [frame.file.relative_to(capture).with_suffix("").as_posix() for frame in there]
    cameras = [_fixed(frame, (name,), (frame.file,)) for frame, name in zip(there, names, strict=True)]
    return Rig(files, cameras, notes=_missing(files, frames))


def _videos(files: tuple[Path, ...], cameras: list[list[_Frame]], moments: set[float | None]) -> Rig:
    """Return cameras with several pictures each, in the order of their times or else of their names."""
    timed = len(moments) > 1
    if timed and None in moments:
        raise InputError(files[0], "some frames have a time and some have none", "give all of them their times")
    names = [frames[0].file.parent.name for frames in cameras]
    if len(set(names)) < len(names) or any(len({f.file.parent for f in frames}) > 1 for frames in cameras):
        names = [f"camera{number:02d}" for number in range(len(cameras))]
    numbers, in_seconds = _frame_numbers({moment for moment in moments if moment is not None})
    found = []
    for name, frames in zip(names, cameras, strict=True):
        if timed:
            frames = sorted((f for f in frames if f.file.is_file()), key=lambda frame: frame.time or 0.0)
        else:
            frames = sorted(frames, key=lambda frame: natural_order(frame.file.name))
        if not frames:
            raise InputError(files[0], f"camera {name} has none of its pictures", "restore the pictures")
        stamps = tuple(numbers[frame.time] for frame in frames if frame.time is not None) if timed else ()
        found.append(_fixed(frames[0], (name,), tuple(frame.file for frame in frames), stamps))
    every = [frame for frames in cameras for frame in frames]
    return Rig(files, found, notes=_missing(files, every) if timed else (), stamps_in_seconds=in_seconds)


def _frame_numbers(moments: set[float]) -> tuple[dict[float, float], bool]:
    """Return the number of the frame, or the second, of every time, and whether they are seconds.

    Times from 0 to 1 are shares of the whole, as D-NeRF has them; whole numbers are frames; others are seconds.
    """
    ordered = sorted(moments)
    if len(ordered) < 2:
        return dict.fromkeys(ordered, 0.0), False
    if ordered[0] >= 0 and ordered[-1] <= 1:
        step = float(np.diff(ordered).min())
        return {moment: float(round((moment - ordered[0]) / step)) for moment in ordered}, False
    return {moment: moment for moment in ordered}, not all(float(moment).is_integer() for moment in ordered)


def _folders_of_one_listed(frames: list[_Frame]) -> list[str]:
    """Return the folders of the frames' pictures if each is the only listed one of a folder that has more."""
    folders = [frame.file.parent for frame in frames]
    if len(set(folders)) < len(folders) or len(folders) < 2:
        return []
    more = all(sum(is_picture(name) for name in list_folder(folder)) > 1 for folder in folders)
    return [folder.name for folder in folders] if more and len({f.name for f in folders}) == len(folders) else []


def _whole(frame: _Frame) -> CalibratedCamera:
    """Return the camera of a frame that names a whole video or a folder of pictures."""
    if frame.file.is_dir():
        return _fixed(frame, (frame.file.name,))
    return _fixed(frame, (frame.file.stem,), (frame.file,))


def _fixed(
    frame: _Frame, names: tuple[str, ...], pictures: tuple[Path, ...] = (), stamps: tuple[float, ...] = ()
) -> CalibratedCamera:
    size = None
    if "w" not in frame.values:
        shown = next((file for file in pictures if is_picture(file.name) and file.is_file()), None)
        size = picture_size(shown) if shown else None
    camera = camera_of_frame(frame.values, size, frame.where)
    return CalibratedCamera(
        camera.where, names, camera.world_to_camera, camera.focal, camera.centre, camera.size, camera.lens,
        pictures, stamps,
    )  # fmt: skip


def _files(capture: Path) -> list[Path]:
    if (file := capture / TRANSFORMS_FILE).is_file():
        return [file]
    names = sorted(name for name in list_folder(capture) if name.startswith("transforms_") and name.endswith(".json"))
    return [capture / name for name in names]


def _frames(capture: Path, file: Path) -> list[_Frame]:
    try:
        meta: Any = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise unreadable(file, error, "restore the file from its source") from error
    frames = meta.get("frames") if isinstance(meta, dict) else None
    one_file = file.name == TRANSFORMS_FILE
    if not isinstance(frames, list) or (one_file and not frames) or not all(isinstance(f, dict) for f in frames):
        raise InputError(file, "frames is not a list of objects", "restore the file from its source")
    shared = {name: value for name, value in meta.items() if name != "frames"}
    return [
        _Frame(f"{file}, frame {number}", _picture(capture, file, number, frame), {**shared, **frame})
        for number, frame in enumerate(frames)
    ]


def _picture(capture: Path, where: Path, number: int, frame: dict[str, Any]) -> Path:
    name = frame.get("file_path")
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}, frame {number}", f"file_path is {name!r}", "it is the name of a picture")
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise InputError(f"{where}, frame {number}", f"file_path {name!r} is outside the capture", "move it below")
    if not Path(name).suffix and not (capture / name).is_dir():  # Blender's files leave it out
        return capture / f"{name}.png"
    return capture / name


def _missing(files: tuple[Path, ...], frames: list[_Frame]) -> tuple[str, ...]:
    missing = [frame.file.name for frame in frames if not frame.file.is_file()]
    if not missing:
        return ()
    named = ", ".join(missing[:_MOST_NAMED]) + (", ..." if len(missing) > _MOST_NAMED else "")
    listed = f"{len(missing)} of the {len(frames)} pictures that {files[0].name} lists"
    return (f"{listed} are not there and left out: {named}",)


def _find(capture: Path) -> Path | None:
    return next(iter(_files(capture)), None)


NERFSTUDIO = CameraFormat("nerfstudio, instant-ngp", "transforms.json", _find, _read)
