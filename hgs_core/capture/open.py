"""Opening a capture of any known layout."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.capture.n3dv import N3DV
from hgs_core.capture.panoptic import PANOPTIC_SPORTS
from hgs_core.capture.picture import list_folder
from hgs_core.capture.transforms import NERFSTUDIO

__all__ = ["LAYOUTS", "open_capture"]

LAYOUTS = (PANOPTIC_SPORTS, N3DV, NERFSTUDIO)
"""In the order in which a folder is tried; a new layout is a module and an entry."""


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
    names = list_folder(path)
    for layout in LAYOUTS:
        if layout.recognises(names):
            return layout.load(path, masks).capture(downscale=downscale, cache_bytes=cache_bytes)
    problem = "the folder is of no known layout" if any(path.iterdir()) else "the folder is empty"
    known = ", ".join(f"{layout.name} ({layout.files})" for layout in LAYOUTS)
    raise InputError(path, problem, f"the layouts known are {known}")
