"""Opening a capture of any known layout."""

from __future__ import annotations

from pathlib import Path

from hgs_core.capture.capture import Capture
from hgs_core.capture.n3dv import POSES_FILE, VIDEO_NAME, load_n3dv
from hgs_core.capture.panoptic import META_FILE, load_panoptic
from hgs_core.capture.picture import list_folder
from hgs_core.capture.recording import Recording
from hgs_core.capture.transforms import TRANSFORMS_FILE, load_transforms
from hgs_core.errors import InputError

__all__ = ["open_capture"]

_LAYOUTS = (
    f"PanopticSports ({META_FILE}, ims/), N3DV ({POSES_FILE}, camNN.mp4) and nerfstudio ({TRANSFORMS_FILE}, images/)"
)


def open_capture(path: Path, *, masks: Path | None = None, downscale: int = 1, cache_bytes: int = 1 << 30) -> Capture:
    """Open the capture in a folder, whatever its layout (docs/captures.md).

    Args:
        path: the folder.
        masks: a folder of masks, `<camera>/<FFFF>.png`, to use instead of the capture's own.
        downscale: pictures and masks are reduced by this whole factor.
        cache_bytes: at most so much of decoded pictures is kept.

    Raises:
        InputError: the folder is missing, empty, of no known layout, or its files are missing, damaged or inconsistent.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> capture = hgs.open_capture(Path("capture"))
        >>> [camera.name for camera in capture.cameras]
        ['0', '1', '2', '3', '4']
        >>> capture.frame(0, 5).shape  # camera 0, frame 5: height, width, sRGB
        (48, 64, 3)
    """
    path = Path(path)
    if not path.is_dir():
        problem = "the capture is a file, not a folder" if path.exists() else "the folder does not exist"
        raise InputError(path, problem, "give the folder of a capture")
    if downscale < 1:
        raise InputError("downscale", f"{downscale} is too small", "give 1 or more")
    return _load(path, masks).capture(downscale=downscale, cache_bytes=cache_bytes)


def _load(path: Path, masks: Path | None) -> Recording:
    names = list_folder(path)
    if META_FILE in names:
        return load_panoptic(path, masks)
    if POSES_FILE in names:
        if not any(VIDEO_NAME.fullmatch(name) for name in names):
            raise InputError(path, f"there is a {POSES_FILE} but no camNN.mp4", "put the videos beside it")
        return load_n3dv(path, masks)
    if TRANSFORMS_FILE in names:
        return load_transforms(path, masks)
    if any(VIDEO_NAME.fullmatch(name) for name in names):
        raise InputError(path, f"there are videos but no {POSES_FILE}", "put the cameras' poses beside them")
    problem = "the folder is of no known layout" if any(path.iterdir()) else "the folder is empty"
    raise InputError(path, problem, f"the layouts known are {_LAYOUTS}")
