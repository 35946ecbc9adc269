"""Cameras from videos: the whole way, with refusals where pictures do not tell enough."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.base.wording import counted
from hgs_core.calibrate.board import Board, find_board
from hgs_core.calibrate.board_rig import cameras_of_board
from hgs_core.calibrate.calibration_views import Pinhole, View, look
from hgs_core.calibrate.colmap_text import write_colmap_text
from hgs_core.calibrate.structure import Solution, solve
from hgs_core.calibrate.uncalibrated import find_videos
from hgs_core.calibrate.upright import Distance, placed
from hgs_core.capture.footage import FEWEST_VIDEOS
from hgs_core.capture.load import clock_of_videos
from hgs_core.capture.pictures.video import VideoReader

__all__ = ["COLMAP_FOLDER", "cameras_of_views", "find_cameras"]

COLMAP_FOLDER = Path("sparse", "0")
"""Where the cameras are written, below the folder of the videos."""

_FEWEST_FEATURES = 40  # features of each camera explained by points of the scene
_LARGEST_ERROR = 2.0  # pixels
_CURE = "add cameras in between, at most 30 degrees apart, or show them a board (--board, docs/cameras.md)"


def find_cameras(
    folder: Path,
    *,
    found: Path | None = None,
    focal: float | None = None,
    up: str | None = None,
    distance: Distance | None = None,
    board: Board | None = None,
    floor: bool = False,
    progress: ProgressCallback = silent,
) -> Solution:
    """Find the cameras of the videos in a folder, and write them below it as COLMAP's text files.

    Args:
        folder: one video of each camera, with cameras that stand still; in step, or with a sync.json, timestamps.csv or
            time stamps that say when they began.
        found: where to write instead, and where a sync.json may lie that the folder has none of.
        focal: the focal length of all cameras in pixels, if it is known, of lenses without distortion.
        up: a camera whose picture is upright; without it all cameras are taken to be held level.
        distance: between two cameras; without it, or a board, the scale is arbitrary.
        board: that is held before the cameras: poses and lenses are found from it, in metres.
        floor: whether the board lies on the floor where it is seen first: y is 0 there.
        progress: called with what has been done.

    Raises:
        InputError: there are cameras already, a video is unreadable, or the pictures tell too little.
    """
    where = (found or folder) / COLMAP_FOLDER
    if (where / "cameras.txt").exists() or (where / "cameras.bin").exists():
        raise InputError(where, "there are cameras already", "move them away to have them found again")
    files = find_videos(folder)
    names, videos = list(files), [VideoReader(file, square=True) for file in files.values()]
    clock, _ = clock_of_videos(folder, names, videos, found)

    def read(camera: int, frame: int) -> npt.NDArray[np.uint8]:
        return videos[camera].read(int(clock.frames[camera, frame]), 0)[0]

    if board is not None:
        sightings = find_board(board, len(videos), read, len(clock.times), progress)
        sizes = [(video.width, video.height) for video in videos]
        solution = cameras_of_board(folder, names, sizes, board, sightings, focal, floor)
        solution = solution if floor else placed(solution, up, metric=True)
        write_colmap_text(where, solution)
        return solution
    known = [None if focal is None else Pinhole(focal, focal, video.width / 2, video.height / 2) for video in videos]
    views = look(names, known, read, len(clock.times), progress)
    solution = placed(cameras_of_views(folder, views, progress), up, distance)
    write_colmap_text(where, solution)
    return solution


def cameras_of_views(where: Path, views: list[View], progress: ProgressCallback) -> Solution:
    """Return the cameras of all views.

    Raises:
        InputError: fewer than three views, or views that cannot be placed; names them and the cure.
    """
    if len(views) < FEWEST_VIDEOS:
        raise InputError(where, f"{counted(len(views), 'camera')} are too few to find poses", _CURE)
    solution = solve(views, progress)
    if solution is None:
        raise InputError(where, "no two cameras share enough of what they see to find poses", _CURE)
    seen = {camera.name: camera.observations for camera in solution.cameras}
    lost = [view.name for view in views if seen.get(view.name, 0) < _FEWEST_FEATURES]
    if lost:
        problem = f"{len(lost)} of {counted(len(views), 'camera')} cannot be placed ({', '.join(lost)})"
        raise InputError(where, f"{problem}: they share too little of what they see with the others", _CURE)
    if solution.error > _LARGEST_ERROR:
        problem = f"the poses that fit best leave {solution.error:.1f} px on average"
        raise InputError(where, problem, "are the videos synchronous, and do the cameras stand still?")
    return solution
