"""The N3DV (Neural 3D Video) layout: poses_bounds.npy, camNN.mp4, and optionally masks/camNN/FFFF.png.

`poses_bounds.npy` follows LLFF (Mildenhall et al., SIGGRAPH 2019): one row of 17 values per camera in the order of the
cameras' names, a 3x5 matrix [R | t | (height, width, focal)] and the nearest and farthest depth. [R | t] is
camera-to-world and the columns of R point down, right and backwards.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.layout import Layout, Outline
from hgs_core.capture.mask_files import find_masks
from hgs_core.capture.picture import list_folder
from hgs_core.capture.recording import Recording
from hgs_core.capture.video import VideoReader, announced_length
from hgs_core.scene.camera import Camera

__all__ = ["N3DV", "POSES_FILE", "VIDEO_NAME", "camera_from_pose", "load_n3dv"]

POSES_FILE = "poses_bounds.npy"
VIDEO_NAME = re.compile(r"cam(\d+)\.mp4")


class _Videos:
    """One open decoder per camera."""

    def __init__(self, videos: list[VideoReader]) -> None:
        self._videos = videos

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], list[Neighbour]]:
        return self._videos[camera].read(frame, neighbours)


def load_n3dv(path: Path, masks: Path | None) -> Recording:
    """Read a capture in the N3DV layout; `masks` replaces its own folder masks/.

    Raises:
        InputError: poses_bounds.npy is unreadable or does not fit the videos, a video is missing, truncated or
            unreadable, the videos differ in frame count or rate, or a mask is missing. Damage inside a video shows at
            first use.
    """
    found = list_folder(path)
    names = _video_names(found)
    if not names:
        raise InputError(path, f"there is a {POSES_FILE} but no camNN.mp4", "put the videos beside it")
    if POSES_FILE not in found:
        raise InputError(path, f"there are videos but no {POSES_FILE}", "put the cameras' poses beside them")
    poses = _read_poses(path / POSES_FILE)
    if len(poses) != len(names):
        problem = f"{counted(len(poses), 'pose')} for {counted(len(names), 'video')}"
        raise InputError(path / POSES_FILE, problem, "every camNN.mp4 needs one row, in the order of the names")
    videos = [VideoReader(path / name) for name in names]
    _require_agreement(path, videos)
    cameras = [
        camera_from_pose(name[:-4], video.width, video.height, pose, f"{path / POSES_FILE}, row {row}")
        for row, (name, video, pose) in enumerate(zip(names, videos, poses, strict=True))
    ]
    return Recording(
        path,
        cameras,
        np.arange(len(videos[0])) / float(videos[0].rate),
        _Videos(videos),
        find_masks(masks or path / "masks", cameras, len(videos[0]), required=masks is not None),
        [(path / name, found[name]) for name in names],
        path / POSES_FILE,
    )


def camera_from_pose(
    name: str,
    width: int,  # of the video, pixels
    height: int,
    pose: npt.NDArray[np.float64],  # [17], a row of poses_bounds.npy
    where: str,
) -> Camera:
    """Return the OpenCV camera of an LLFF pose; the principal point is the middle of the picture.

    The row may be for a picture of another size, which is scaled: (height, width, focal) become the video's.

    Raises:
        InputError: values that are no camera, or an aspect ratio other than the video's.
    """
    if not np.isfinite(pose).all():
        raise InputError(where, "the pose holds NaN or infinity", "estimate the cameras again")
    matrix = pose[:15].reshape(3, 5)
    stated_height, stated_width, focal = matrix[:, 4]
    if not (stated_height > 0 and stated_width > 0 and focal > 0):
        problem = f"(height, width, focal) is ({stated_height:g}, {stated_width:g}, {focal:g})"
        raise InputError(where, problem, "all three are positive, in pixels")
    sx, sy = width / stated_width, height / stated_height
    if abs(sx / sy - 1.0) > 0.02:  # rounding a side to whole or even pixels stays below this
        problem = f"the pose is for {stated_width:g}x{stated_height:g} pixels and the video has {width}x{height}"
        on_its_side = abs(width * stated_width / (height * stated_height) - 1.0) <= 0.02
        cure = "estimate the cameras from pictures as players show them, upright" if on_its_side else ""
        raise InputError(where, problem, cure or "scale the videos without cropping")
    down, right, back, position = matrix[:, 0], matrix[:, 1], matrix[:, 2], matrix[:, 3]
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3] = np.stack((right, down, -back))  # rows: the x, y and z axes of the camera in the world
    world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ position
    try:
        return Camera(name, width, height, focal * sx, focal * sy, width / 2, height / 2, world_to_camera)
    except InputError as error:
        raise InputError(where, error.problem, error.cure) from error


def _read_poses(path: Path) -> npt.NDArray[np.float64]:
    try:
        poses = np.asarray(np.load(path, allow_pickle=False), np.float64)
    except (OSError, ValueError, EOFError) as error:
        raise InputError(path, f"unreadable ({error})", "restore the file from its source") from error
    if poses.ndim != 2 or poses.shape[1] != 17:
        raise InputError(path, f"the array is {poses.shape}", "it has one row of 17 values per camera")
    return poses


def _require_agreement(path: Path, videos: list[VideoReader]) -> None:
    """Refuse videos that cannot be synchronous."""
    counts = [len(video) for video in videos]
    if len(set(counts)) > 1:
        usual = max(set(counts), key=counts.count)
        odd = ", ".join(f"{v.path.name} has {n}" for v, n in zip(videos, counts, strict=True) if n != usual)
        problem = f"the cameras differ in frame count: {odd}, the others have {usual}"
        raise InputError(path, problem, "cut all videos to the same frames")
    for video in videos:
        if abs(video.rate / videos[0].rate - 1) > 0.001:
            problem = f"{float(video.rate):g} frames per second, {videos[0].path.name} has {float(videos[0].rate):g}"
            raise InputError(video.path, problem, "export all videos at the same rate")


def _outline(path: Path) -> Outline:
    """Return the cameras by the names of their videos, and the length that the first video's header announces."""
    names = _video_names(list_folder(path))
    frames, rate = announced_length(path / names[0]) if names else (None, None)
    seconds = frames / rate if frames is not None and rate is not None else None
    return Outline(tuple(name[:-4] for name in names), frames, seconds)


def _video_names(names: Iterable[str]) -> list[str]:
    return sorted((name for name in names if VIDEO_NAME.fullmatch(name)), key=lambda name: (int(name[3:-4]), name))


def _is_n3dv(names: Iterable[str]) -> bool:
    """Whether some of what the layout needs is there; `load_n3dv` says what is not."""
    return any(name == POSES_FILE or VIDEO_NAME.fullmatch(name) for name in names)


N3DV = Layout("N3DV", f"{POSES_FILE}, camNN.mp4", _is_n3dv, load_n3dv, _outline)
