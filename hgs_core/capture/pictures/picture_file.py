"""One picture in a file: its header, and its pixels, as far as they can be trusted.

Only formats that hold pixels are opened: Pillow would also run Ghostscript for a PostScript file of any name. A header
is read before memory is taken for what it announces. What is transparent shows black, the background of scenes.
"""

from __future__ import annotations

import shlex
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.colour_profile import colour_profile

__all__ = ["PictureHeader", "has_transparency", "read_header", "read_pixels"]

_FORMATS = ("PNG", "JPEG", "JPEG2000", "TIFF", "BMP", "WEBP", "PPM", "TGA")
_ENDINGS = ("png", "jpg", "jpeg", "tif", "tiff", "webp")  # endings that a converted picture may keep
_MOVING = ("PNG", "WEBP")  # several pictures in a file are an animation; elsewhere pages, or views of a camera
_MOST_PIXELS = 160_000_000  # more than any sensor has; Pillow refuses what is a little larger by itself
_ORIENTATION = 274  # tag of EXIF
_TURNED = {  # EXIF orientation -> turn to upright
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
_BACK = {6: Image.Transpose.ROTATE_90, 8: Image.Transpose.ROTATE_270}  # the others undo themselves

_QUIET = threading.Lock()  # held while Pillow's warnings, of large pictures and odd tags, are ignored


@dataclass(frozen=True)
class PictureHeader:
    """The header of a picture."""

    size: tuple[int, int]  # width and height as stored, pixels
    orientation: int = 1  # EXIF's: 1 is upright as stored, 5 to 8 lie on their side
    transparent: bool = False  # whether it may be so anywhere
    pictures: int = 1  # pictures in the file
    profile: str = ""  # name of a colour profile other than sRGB

    @property
    def upright(self) -> tuple[int, int]:
        """Width and height as EXIF has it shown, pixels."""
        return (self.size[1], self.size[0]) if self.orientation > 4 else self.size


def read_header(path: Path) -> PictureHeader:
    """Return the header of a picture.

    Raises:
        InputError: the file is missing, unreadable, an animation, or announces more pixels than a picture may have.
    """
    with _opened(path) as image:
        orientation = _orientation(image)
        width, height = image.size
        lies = image.format == "TIFF" and orientation > 4  # Pillow has brought its size upright
        size = (height, width) if lies else (width, height)
        profile, pictures = colour_profile(image), int(getattr(image, "n_frames", 1))
        name = "" if profile is None else profile.name
        return PictureHeader(size, orientation, image.has_transparency_data, pictures, name)


def read_pixels(path: Path, *, upright: bool = False, colours: bool = True) -> npt.NDArray[np.uint8]:
    """Return the pixels [H, W, 3] of a picture on black, or with `colours` False as they are stored.

    They are as stored, or `upright` as EXIF says.

    Raises:
        InputError: as `read_header`, or the file is damaged.
    """
    with _opened(path) as image:
        orientation = _orientation(image)
        stands = image.format == "TIFF"  # Pillow turns those itself
        if colours and image.mode == "F":
            cure = f"store 16 bits per channel: {_converted(path, '-depth 16', '.png')}"
            raise InputError(path, "the picture has floating-point values, whose white nothing states", cure)
        image.load()
        shown: Image.Image = image
        if upright and not stands and orientation in _TURNED:
            shown = image.transpose(_TURNED[orientation])
        elif stands and not upright and orientation in _TURNED:
            shown = image.transpose(_BACK.get(orientation, _TURNED[orientation]))
        return _colours(shown) if colours else np.array(shown)


def has_transparency(path: Path) -> bool:
    """Return whether any pixel of a picture is transparent.

    Raises:
        InputError: as `read_pixels`.
    """
    with _opened(path) as image:
        if not image.has_transparency_data or image.mode.startswith("I"):
            return image.has_transparency_data
        return bool(np.asarray(image.convert("RGBA").getchannel("A")).min() < 255)


def _colours(image: Image.Image) -> npt.NDArray[np.uint8]:
    if image.mode.startswith("I"):  # 16 bits of grey, which Pillow would cut off at 255
        values = np.asarray(image)
        levels = (values.clip(0, 65535) / 257 + 0.5).astype(np.uint8)
        if (clear := image.info.get("transparency")) is not None:
            levels[values == clear] = 0
        return np.repeat(levels[..., None], 3, axis=2)
    if (profile := colour_profile(image)) is not None:
        image = profile.in_srgb(image)
    if image.has_transparency_data:
        over = image.convert("RGBA")
        return np.array(Image.alpha_composite(Image.new("RGBA", over.size, (0, 0, 0, 255)), over).convert("RGB"))
    return np.array(image.convert("RGB"))


def _orientation(image: Image.Image) -> int:
    if image.format == "PNG" and "exif" not in image.info:
        return 1  # Pillow would decode the picture to look for it behind
    try:
        with _QUIET, warnings.catch_warnings(action="ignore"):
            found = image.getexif().get(_ORIENTATION, 1)
    except Exception:  # tags are damaged in as many ways as pictures, which they leave whole
        return 1
    return found if found in _TURNED else 1


@contextmanager
def _opened(path: Path) -> Iterator[Image.Image]:
    Image.init()  # or formats beyond the five most usual are not known
    try:
        with _QUIET, warnings.catch_warnings(action="ignore"):
            image = Image.open(path, formats=_FORMATS)
        with image:
            if image.width * image.height > _MOST_PIXELS:
                raise _too_large(path, f"{image.width}x{image.height} pixels")
            if getattr(image, "is_animated", False) and image.format in _MOVING:
                parts = _converted(path, "-coalesce", "-%04d.png")
                if image.format == "PNG":
                    parts = f"ffmpeg -f apng -i {shlex.quote(path.name)} {shlex.quote(path.stem + '-%04d.png')}"
                cure = f"store each as a picture of its own, and take this file away: {parts}"
                raise InputError(path, f"the file is an animation of {getattr(image, 'n_frames', 2)} pictures", cure)
            yield image
    except InputError:
        raise
    except Image.DecompressionBombError as error:
        raise _too_large(path, "far more pixels than a picture has") from error
    except UnidentifiedImageError as error:
        raise _unknown(path) from error
    except Exception as error:  # damaged files make Pillow raise errors of every kind
        raise _unreadable(path, error) from error


def _too_large(path: Path, what: str) -> InputError:
    return InputError(path, f"the picture announces {what}", f"give one of at most {_MOST_PIXELS:,} pixels")


def _unknown(path: Path) -> InputError:
    """Return the error for a file that is of no format that is read."""
    with path.open("rb") as file:
        head = file.read(32)
    kind = ""
    if head[4:8] == b"ftyp":
        kind = {b"avif": "AVIF", b"avis": "AVIF"}.get(head[8:12], "HEIC")
    elif head.startswith(b"GIF8"):
        kind = "GIF"
    read = "PNG, JPEG, JPEG 2000, TIFF, BMP, WebP, PPM and TGA are read"
    if not kind:
        return InputError(path, f"the picture is unreadable: of no known kind; {read}", "restore or convert it")
    ending = path.suffix.lower().removeprefix(".")
    into = ending if ending in _ENDINGS else "png"
    cure = f"convert all of the folder: mogrify -format {into} *{path.suffix}"
    return InputError(path, f"the picture is {kind}, and {read}", cure)


def _converted(path: Path, options: str, ending: str) -> str:
    words = ("convert", shlex.quote(path.name), options, shlex.quote(path.stem + ending))
    return " ".join(word for word in words if word)


def _unreadable(path: Path, error: Exception) -> InputError:
    if isinstance(error, FileNotFoundError):
        return InputError(path, "the picture is missing", "restore the file")
    if isinstance(error, PermissionError):
        return InputError(path, "the picture may not be read", "make it readable")
    return InputError(path, f"the picture is unreadable ({error})", "restore the file from its source")
