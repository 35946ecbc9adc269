"""Colour profiles (ICC) in pictures: Adobe RGB, Display P3 and the like are brought to sRGB."""

from __future__ import annotations

import io
import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageCms

__all__ = ["ColourProfile", "colour_profile"]

_LEVELS = (0, 64, 128, 192, 255)  # compared levels of a channel
_SAME = 4  # levels; profiles of sRGB differ by their makers' rounding
_MODES = ("RGB", "RGBA")
_LONGEST = 40  # characters of a description


@dataclass(frozen=True)
class ColourProfile:
    """A profile with colours other than sRGB."""

    name: str  # description, for people
    data: bytes

    def in_srgb(self, image: Image.Image) -> Image.Image:
        """Return a picture of `data` with the colours of sRGB; alpha stays."""
        found = ImageCms.applyTransform(image, _transform(self.data, image.mode))
        assert found is not None
        return found


def colour_profile(image: Image.Image) -> ColourProfile | None:
    """Return the profile of an open picture; None: it has none, a damaged one, or one that is as good as sRGB."""
    data = image.info.get("icc_profile")
    if image.mode not in _MODES or not isinstance(data, bytes) or not data:
        return None
    name = _name(data)
    return None if name is None else ColourProfile(name, data)


@lru_cache(maxsize=16)
def _name(data: bytes) -> str | None:
    cube = np.array([list(itertools.product(_LEVELS, repeat=3))], np.uint8)
    try:
        shown = ImageCms.applyTransform(Image.fromarray(cube), _transform(data, "RGB"))
        if np.abs(np.asarray(shown).astype(int) - cube).max() <= _SAME:
            return None
        said = ImageCms.getProfileDescription(ImageCms.ImageCmsProfile(io.BytesIO(data)))
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return None
    return " ".join(said.split())[:_LONGEST] or "unnamed"


@lru_cache(maxsize=32)
def _transform(data: bytes, mode: str) -> ImageCms.ImageCmsTransform:
    profile = ImageCms.ImageCmsProfile(io.BytesIO(data))
    intent = ImageCms.Intent.RELATIVE_COLORIMETRIC
    return ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), mode, mode, intent)
