"""Cameras of instant-ngp and nerfstudio: transforms.json, or transforms_train.json and its like, which name pictures.

Intrinsics are `fl_x`, `fl_y` (or `camera_angle_x`), `cx`, `cy`, `w`, `h` and the distortion `k1`...`k4`, `p1`, `p2`,
for all pictures or in a frame of their own; per frame the picture `file_path`, perhaps its `time`, and
`transform_matrix` [4, 4], which is camera-to-world in the convention of OpenGL: x right, y up, z backwards.

Frames of one pose are the pictures of one fixed camera, also where it was solved picture by picture and differs a
little. Where all poses differ the pictures are photographs of one moment, or, if their times differ, of one camera that
moves, which is refused.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.rig import CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.cameras.steady_pose import differing, median_pose, pose_groups, rig_radius, spread, strays
from hgs_core.capture.cameras.transforms_file import TRANSFORMS_FILE, Frame, missing, read_frames, transforms_files
from hgs_core.capture.cameras.transforms_frame import camera_of_frame
from hgs_core.capture.cameras.transforms_times import FrameTimes, frame_times
from hgs_core.capture.footage import is_picture, is_video, natural_order
from hgs_core.capture.pictures.picture import list_folder, picture_size

__all__ = ["NERFSTUDIO"]

Pose = npt.NDArray[np.float64]


def _read(capture: Path, file: Path) -> Rig:
    files = tuple(transforms_files(capture))
    frames, notes = read_frames(capture, files)
    rig = _rig(capture, file, files, frames)
    return dataclasses.replace(rig, notes=(*notes, *rig.notes))


def _rig(capture: Path, file: Path, files: tuple[Path, ...], frames: list[Frame]) -> Rig:
    poses = [camera_of_frame(frame.values, None, frame.where).world_to_camera for frame in frames]
    moments = {frame.time for frame in frames}
    if all(is_video(frame.file.name) or frame.file.is_dir() for frame in frames):
        return Rig(files, [_whole(frame) for frame in frames])
    cameras, notes = _cameras(frames, poses)
    _require_no_strays(file, frames, poses)
    if len(cameras) == len(frames):
        if len(moments) > 1 or file.name.lower() != TRANSFORMS_FILE:
            problem = f"its {len(frames)} frames are each from another place: one camera that moves (D-NeRF, Blender)"
            cure = (
                "HGS needs several cameras that stand still: one view of a moment leaves open what moves, and how far"
            )
            raise InputError(file, problem, f"{cure} away it is")
        if folders := _folders_of_one_listed(frames):
            return Rig(files, [_fixed(frame, (folder,)) for frame, folder in zip(frames, folders, strict=True)])
    if len(moments) > 1 or (len(cameras) < len(frames) and min(len(own) for own, _ in cameras) > 1):
        return _videos(files, cameras, moments, notes)
    return _photographs(capture, files, frames)


def _cameras(frames: list[Frame], poses: list[Pose]) -> tuple[list[tuple[list[Frame], Pose]], list[str]]:
    """Return the frames and pose of each camera, with notes; poses that are nearly alike count as one camera's."""
    alike: dict[tuple[str, bytes], list[int]] = defaultdict(list)
    for index, (frame, pose) in enumerate(zip(frames, poses, strict=True)):
        alike[frame.intrinsics, (np.round(pose, 6) + 0.0).tobytes()].append(index)
    exact = [([frames[index] for index in own], poses[own[0]]) for own in alike.values()]
    radius = rig_radius(poses)
    near: list[list[int]] = []
    for lens in dict.fromkeys(frame.intrinsics for frame in frames):
        groups = [own for (intrinsics, _), own in alike.items() if intrinsics == lens]
        for group in pose_groups([poses[own[0]] for own in groups], radius):
            near.append([index for one in group for index in groups[one]])
    if len(near) == len(exact) or not _stand_still([[frames[index] for index in own] for own in near]):
        return exact, []
    found = [([frames[index] for index in own], median_pose([poses[index] for index in own])) for own in near]
    differ = spread([[poses[index] for index in own] for own in near], radius)
    return found, [differing(differ)] if differ else []


def _stand_still(cameras: list[list[Frame]]) -> bool:
    """Whether nearly equal poses are cameras', not stretches of one camera's way: each lasts, or has a folder."""
    folders = [{frame.file.parent for frame in own} for own in cameras]
    if len(cameras) > 1 and all(len(own) == 1 for own in folders) and len(set.union(*folders)) == len(cameras):
        return True
    times = [[frame.time for frame in own if frame.time is not None] for own in cameras]
    if min(map(len, times)) < 2:
        return False
    spans = [max(own) - min(own) for own in times]
    whole = max(map(max, times)) - min(map(min, times))
    return min(spans) > 0.5 * whole


def _require_no_strays(file: Path, frames: list[Frame], poses: list[Pose]) -> None:
    """Refuse few poses that are elsewhere than all others of a folder, where each folder is a camera's.

    Raises:
        InputError: names the first such frame.
    """
    folders: dict[Path, list[int]] = defaultdict(list)
    for index, frame in enumerate(frames):
        folders[frame.file.parent].append(index)
    radius = rig_radius(poses)
    found = [own[stray] for own in folders.values() for stray in strays([poses[index] for index in own], radius)]
    if found and len(folders) > 1:
        more = f", and {len(found) - 1} more like this" if len(found) > 1 else ""
        named = shown(str(frames[found[0]].values["file_path"]))
        problem = f"{named} has another pose than most pictures of its folder{more}"
        raise InputError(file, problem, "correct its transform_matrix, or take the frame out of the list")


def _photographs(capture: Path, files: tuple[Path, ...], frames: list[Frame]) -> Rig:
    there = [frame for frame in frames if frame.file.is_file()]
    if not there:
        cure = f"put them where file_path says, the first at {frames[0].file}"
        raise InputError(files[0], f"none of its {len(frames)} pictures is there", cure)
    names = [frame.file.stem for frame in there]
    if len(set(names)) < len(names):
        names = [frame.file.relative_to(capture).with_suffix("").as_posix() for frame in there]
    cameras = [_fixed(frame, (name,), (frame.file,)) for frame, name in zip(there, names, strict=True)]
    return Rig(files, cameras, notes=missing(files, frames))


def _videos(
    files: tuple[Path, ...],
    cameras: list[tuple[list[Frame], Pose]],
    moments: set[float | None],
    notes: Sequence[str],
) -> Rig:
    """Return cameras with several pictures each, in the order of their times or else of their names."""
    timed = len(moments) > 1
    if timed and None in moments:
        raise InputError(files[0], "some frames have a time and some have none", "give all of them their times")
    names = [frames[0].file.parent.name for frames, _ in cameras]
    if len(set(names)) < len(names) or any(len({f.file.parent for f in frames}) > 1 for frames, _ in cameras):
        names = [f"camera{number:02d}" for number in range(len(cameras))]
    times = frame_times(files[0], [frames for frames, _ in cameras]) if timed else FrameTimes()
    found = []
    for name, (frames, pose) in zip(names, cameras, strict=True):
        if timed:
            frames = sorted((f for f in frames if f.file.is_file()), key=lambda frame: frame.time or 0.0)
            _require_own_times(files[0], name, frames)
        else:
            frames = sorted(frames, key=lambda frame: natural_order(frame.file.name))
        if not frames:
            raise InputError(files[0], f"camera {name} has none of its pictures", "restore the pictures")
        stamps = tuple(times.stamps[frame.time] for frame in frames if frame.time is not None) if timed else ()
        camera = _fixed(frames[0], (name,), tuple(frame.file for frame in frames), stamps)
        found.append(dataclasses.replace(camera, world_to_camera=pose))
    every = [frame for frames, _ in cameras for frame in frames]
    said = (*notes, *times.notes, *(missing(files, every) if timed else ()))
    return Rig(files, found, notes=said, stamps_in_seconds=times.in_seconds)


def _require_own_times(file: Path, name: str, frames: list[Frame]) -> None:
    """Refuse two pictures of one camera at one time: nothing tells which of them is wrong."""
    for first, second in pairwise(frames):
        if first.time == second.time:
            problem = f"{first.file.name} and {second.file.name} of {name} both have the time {first.time:.6g}"
            cure = 'correct one of them, or remove "time" from all frames: they then come in the order of their names'
            raise InputError(file, problem, cure)


def _folders_of_one_listed(frames: list[Frame]) -> list[str]:
    """Return the folders of the frames' pictures if each is the only listed one of a folder that has more."""
    folders = [frame.file.parent for frame in frames]
    if len(set(folders)) < len(folders) or len(folders) < 2:
        return []
    more = all(sum(is_picture(name) for name in list_folder(folder)) > 1 for folder in folders)
    return [folder.name for folder in folders] if more and len({f.name for f in folders}) == len(folders) else []


def _whole(frame: Frame) -> CalibratedCamera:
    """Return the camera of a frame that names a whole video or a folder of pictures."""
    if frame.file.is_dir():
        return _fixed(frame, (frame.file.name,))
    return _fixed(frame, (frame.file.stem,), (frame.file,))


def _fixed(
    frame: Frame, names: tuple[str, ...], pictures: tuple[Path, ...] = (), stamps: tuple[float, ...] = ()
) -> CalibratedCamera:
    size = None
    if "w" not in frame.values:
        shown = next((file for file in pictures if is_picture(file.name) and file.is_file()), None)
        size = picture_size(shown) if shown else None
    camera = camera_of_frame(frame.values, size, frame.where)
    return dataclasses.replace(camera, names=names, pictures=pictures, stamps=stamps)


def _find(capture: Path) -> Path | None:
    return next(iter(transforms_files(capture)), None)


NERFSTUDIO = CameraFormat("nerfstudio, instant-ngp", "transforms.json", _find, _read)
