"""Opening a capture of any known layout."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cameras.camera_formats import CAMERA_FORMATS, calibration
from hgs_core.capture.capture import Capture
from hgs_core.capture.footage import FEWEST_VIDEOS, find_places, require_folder
from hgs_core.capture.load import load
from hgs_core.capture.sound.sound_only import is_sound_only

__all__ = ["open_capture"]


def open_capture(
    path: Path,
    *,
    masks: Path | None = None,
    depth: Path | None = None,
    mesh: Path | None = None,
    downscale: int = 1,
    reductions: Mapping[str, int] = MappingProxyType({}),
    cache_bytes: int = 1 << 30,
    found: Path | None = None,
    index: Path | None = None,
) -> Capture:
    """Open the capture in a folder of any layout (docs/captures.md).

    Args:
        path: the folder.
        masks: a folder of masks, `<camera>/<FFFF>.png`, to use instead of the capture's own.
        depth: a folder of depth maps with their depth.json, to use instead of the capture's own.
        mesh: a PLY, OBJ or GLB file of triangles, to use instead of the capture's own.
        downscale: pictures and masks are reduced by this whole factor.
        reductions: by camera, where it is another factor.
        cache_bytes: at most so much of decoded pictures is kept.
        found: a folder with cameras, or a sync.json, that count where the capture has none of its own.
        index: a folder that keeps the time stamps of videos, so that the next opening does not read all packets again.

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
    require_folder(path, "give the folder of a capture")
    for factor in (downscale, *reductions.values()):
        if factor < 1:
            raise InputError("downscale", f"{factor} is too small", "give 1 or more")
    known = list(calibration(path))
    if not known and found is not None:
        known = list(calibration(found))[:1]
    if not known:
        raise _unknown(path)
    recording = load(path, *known[0], masks, found, index, depth=depth, mesh=mesh)
    aside = ", ".join(str(file.relative_to(path)) for _, file in known[1:])
    notes = (f"the cameras are those of {known[0][1].relative_to(path)}; {aside} is left aside",) if aside else ()
    return recording.capture(downscale=downscale, reductions=reductions, cache_bytes=cache_bytes, notes=notes)


def _unknown(path: Path) -> InputError:
    known = ", ".join(f"{camera_format.name} ({camera_format.files})" for camera_format in CAMERA_FORMATS)
    begin = "put a video of each camera into it, cam00.mp4 and so on"
    if not any(path.iterdir()):
        return InputError(path, "the folder is empty", begin)
    places = find_places(path)
    if not places:
        return InputError(path, f"the folder is of no known layout; the cameras' formats known are {known}", begin)
    place = min(places, key=lambda place: place.kind == "photographs")
    count = sum(not (one.video and is_sound_only(one.files[0])) for one in place.footage)
    what = {"videos": ("video", ""), "folders": ("folder of pictures", "folders of pictures")}.get(place.kind)
    there = f"there are {counted(count, *(what or ('picture', '')))} but no file of the cameras' poses"
    cure = "put one beside them: COLMAP writes sparse/0/cameras.bin and images.bin"
    if place.kind == "videos" and count >= FEWEST_VIDEOS:
        cure = f"have them found: hgs cameras {shlex.quote(str(path))}"
    return InputError(path, f"{there}, of the formats {known}", cure)
