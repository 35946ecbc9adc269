"""SOG files as they are written: splats as pixels of lossless WebP pictures, in a zip (`sog_file` tells the layout).

Splats lie in Morton order, so that neighbours in the pictures are alike, which compresses.
"""

from __future__ import annotations

import io
import json
import zipfile

import numpy as np
from numpy.typing import NDArray

from hgs_core.base import morton
from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Change, Written
from hgs_core.interchange.codebook import codebook
from hgs_core.interchange.splat_file import opacity_changes
from hgs_core.interchange.splat_properties import SH_0
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import StaticSplats

__all__ = ["FIRST_TAG", "META", "OTHERS", "SOG_BYTES", "sog_file"]

META = "meta.json"
FIRST_TAG = 252  # tag of the largest component w; x, y and z follow
OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])  # components beside the largest
SOG_BYTES = 20  # pixels of five pictures, before compression
_LEVELS = 65535
_NEVER = (1980, 1, 1, 0, 0, 0)  # date in the zip: equal scenes are equal files
_EFFORT = 4  # WebP's method


def sog_file(splats: StaticSplats[Floats], antialiased: bool = False) -> Written:
    """Return the file of a still scene.

    Raises:
        InputError: there are no splats: a picture has pixels.
    """
    count = len(splats)
    if not count:
        raise InputError("splats", "are none, and SOG holds no empty picture", "choose another time")
    means = splats.means.astype(np.float64)
    logarithms = np.sign(means) * np.log1p(np.abs(means))
    low, high = logarithms.min(axis=0), logarithms.max(axis=0)
    places = np.rint((logarithms - low) / np.where(high > low, high - low, 1) * _LEVELS).astype(np.int64)
    scales, scale_numbers = codebook(splats.log_scales)
    harmonics = (splats.rgb.astype(np.float64) - 0.5) / SH_0
    colours, colour_numbers = codebook(harmonics.astype(np.float32))
    opacities = np.rint(opacities_of(splats.opacity_logits) * 255).astype(np.uint8)
    units = unit_quaternions(splats.quats)
    turns, kept_turns = _rotations(units)
    order = morton.order(morton.interleave(places.astype(np.uint32)))  # neighbours one after the other
    pictures = {
        "means_l": _opaque(places & 255),
        "means_u": _opaque(places >> 8),
        "scales": _opaque(scale_numbers),
        "quats": turns,
        "sh0": np.concatenate([colour_numbers, opacities[:, None]], axis=1),
    }
    meta = {
        "version": 2,
        "asset": {"generator": "HGS"},
        "count": count,
        "antialias": antialiased,
        "means": {"mins": low.tolist(), "maxs": high.tolist(), "files": ["means_l.webp", "means_u.webp"]},
        "scales": {"codebook": scales.tolist(), "files": ["scales.webp"]},
        "quats": {"files": ["quats.webp"]},
        "sh0": {"codebook": colours.tolist(), "files": ["sh0.webp"]},
    }
    parts = {META: json.dumps(meta, separators=(",", ":")).encode()}
    parts |= {f"{name}.webp": _picture(pixels[order]) for name, pixels in pictures.items()}
    stored = low + (high - low) * places / _LEVELS
    changes = (
        Change.rounded("position", means, np.sign(stored) * np.expm1(np.abs(stored)), "16 bits of a logarithm"),
        Change.rounded("scale", splats.log_scales, scales[scale_numbers], "one of 256 in a table"),
        Change.rounded("colour", splats.rgb, 0.5 + SH_0 * colours[colour_numbers], "one of 256 in a table"),
        *opacity_changes(splats.opacity_logits, opacities),
        Change.rounded("rotation", units, kept_turns, "8 bits a component"),
    )
    return Written(_zipped(parts), changes)


def _rotations(units: Doubles) -> tuple[NDArray[np.uint8], Doubles]:
    """Return the pixels [N, 4] of unit quaternions, and the quaternions that these pixels hold, of the same signs."""
    rows, largest = np.arange(len(units)), np.abs(units).argmax(axis=1)
    signs = np.where(units[rows, largest] < 0, -1.0, 1.0)[:, None]
    others = np.take_along_axis(units * signs, OTHERS[largest], axis=1)
    bytes_ = np.rint((others / np.sqrt(2) + 0.5) * 255).astype(np.uint8)
    back = (bytes_ / 255 - 0.5) * np.sqrt(2)
    kept = np.zeros_like(units)
    np.put_along_axis(kept, OTHERS[largest], back, axis=1)
    kept[rows, largest] = np.sqrt(np.maximum(0, 1 - (back**2).sum(axis=1)))
    tags = (FIRST_TAG + largest).astype(np.uint8)[:, None]
    return np.concatenate([bytes_, tags], axis=1), kept * signs


def _opaque(numbers: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Return pixels [N, 4] of three numbers each."""
    return np.concatenate([numbers.astype(np.uint8), np.full((len(numbers), 1), 255, np.uint8)], axis=1)


def _picture(pixels: NDArray[np.uint8]) -> bytes:
    """Return the WebP picture of pixels [N, 4], nearly square."""
    from PIL import Image  # not above: `hgs serve` loads this module, and no library that opens pictures

    width = -(-int(np.ceil(np.sqrt(len(pixels)))) // 4) * 4
    rows = -(-len(pixels) // width)
    square = np.zeros((rows * width, 4), np.uint8)
    square[: len(pixels)] = pixels
    buffer = io.BytesIO()
    image = Image.fromarray(square.reshape(rows, width, 4))
    image.save(buffer, "WEBP", lossless=True, exact=True, method=_EFFORT)  # exact: colours where the opacity is 0
    return buffer.getvalue()


def _zipped(parts: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, data in parts.items():
            archive.writestr(zipfile.ZipInfo(name, _NEVER), data)
    return buffer.getvalue()
