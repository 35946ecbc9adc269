"""Pictures brought to the shape that their calibration has: turned as EXIF says, or stretched to square pixels.

Some tools calibrate pictures as they are stored, others as players show them, and none writes which. The size of the
calibrated pictures tells, unless both shapes are alike; then pictures stay as they are stored, and a line says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto

from hgs_core.capture.cameras.rig import CalibratedCamera
from hgs_core.capture.pictures.picture_sequence import PictureSequence
from hgs_core.capture.pictures.video import VideoReader

__all__ = ["show_as_calibrated"]


class _For(Enum):
    """How pictures were when they were calibrated."""

    UPRIGHT = auto()
    STORED = auto()
    OPEN = auto()


def show_as_calibrated(
    cameras: Sequence[CalibratedCamera], names: Sequence[str], readers: Sequence[VideoReader | PictureSequence]
) -> list[str]:
    """Turn or stretch pictures to match their calibration; return notes on the others.

    Raises:
        InputError: a camera's pictures, turned as EXIF says, have different sizes.
    """
    said: dict[str, list[str]] = {}
    turnable: list[tuple[str, PictureSequence, _For]] = []
    for camera, name, reader in zip(cameras, names, readers, strict=True):
        stored = reader.width, reader.height
        if isinstance(reader, PictureSequence):
            if reader.orientations != {1}:
                turnable.append((name, reader, _told(camera, stored, reader.upright_size)))
        elif reader.square_size != stored:
            told = _told(camera, stored, reader.square_size)
            if told is _For.UPRIGHT:
                reader.show_square()
            elif told is _For.OPEN:
                what = "the calibration states no size that tells: pixels are taken as stored, though not square"
                said.setdefault(what, []).append(name)
    every = {told for _, _, told in turnable}
    default = _For.UPRIGHT if _For.UPRIGHT in every and _For.STORED not in every else _For.OPEN
    for name, reader, told in turnable:
        tags = ", ".join(str(one) for one in sorted(reader.orientations))
        if (told if told is not _For.OPEN else default) is _For.UPRIGHT:
            reader.show_upright(name)
            what = f"pictures are turned as EXIF says (orientation {tags}): so they were calibrated"
        elif told is _For.STORED:
            what = f"EXIF's orientation {tags} is left aside: pictures were calibrated as stored"
        else:
            what = (
                f"pictures are taken as stored, though EXIF says orientation {tags}, and no size tells how they were"
                " calibrated: if upright, turn them by mogrify -auto-orient; if not, run exiftool -n -Orientation=1"
            )
        said.setdefault(what, []).append(name)
    return [f"{', '.join(cameras_of)}: {what}" for what, cameras_of in said.items()]


def _told(camera: CalibratedCamera, stored: tuple[int, int], shown: tuple[int, int]) -> _For:
    """Return for which of two shapes a calibration is."""
    if camera.size is None or camera.fits(*stored) == camera.fits(*shown):
        return _For.OPEN
    return _For.STORED if camera.fits(*stored) else _For.UPRIGHT
