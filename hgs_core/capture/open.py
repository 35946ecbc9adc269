"""Opening a capture of any known layout."""

from __future__ import annotations

from pathlib import Path

from hgs_core.capture.capture import Capture
from hgs_core.capture.n3dv import POSES_FILE, VIDEO_NAME, open_n3dv
from hgs_core.capture.panoptic import META_FILE, open_panoptic
from hgs_core.capture.picture import list_folder
from hgs_core.errors import InputError

__all__ = ["open_capture"]

_LAYOUTS = f"PanopticSports ({META_FILE}, ims/) and N3DV ({POSES_FILE}, camNN.mp4)"


def open_capture(path: Path, *, cache_bytes: int = 1 << 30) -> Capture:
    """Open the capture in a folder, whatever its layout; at most `cache_bytes` of decoded pictures are kept.

    Raises:
        InputError: the folder is missing, empty, of no known layout, or its files are missing, damaged or inconsistent.
    """
    path = Path(path)
    if not path.is_dir():
        problem = "the capture is a file, not a folder" if path.exists() else "the folder does not exist"
        raise InputError(path, problem, "give the folder of a capture")
    names = list_folder(path)
    if META_FILE in names:
        return open_panoptic(path, cache_bytes=cache_bytes)
    if POSES_FILE in names:
        if not any(VIDEO_NAME.fullmatch(name) for name in names):
            raise InputError(path, f"there is a {POSES_FILE} but no camNN.mp4", "put the videos beside it")
        return open_n3dv(path, cache_bytes=cache_bytes)
    if any(VIDEO_NAME.fullmatch(name) for name in names):
        raise InputError(path, f"there are videos but no {POSES_FILE}", "put the cameras' poses beside them")
    problem = "the folder is of no known layout" if any(path.iterdir()) else "the folder is empty"
    raise InputError(path, problem, f"the layouts known are {_LAYOUTS}")
