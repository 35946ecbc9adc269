"""SOG files of PlayCanvas, version 2: numbers of splats as pixels of lossless WebP pictures, in a zip or a folder.

`meta.json` says how many splats there are and what pixels stand for. Positions have 16 bits, in two pictures, of
sign(x) ln(1 + |x|) between bounds; rotations the number of their largest component and 8 bits for each of the others;
scales (logarithms) and colours (harmonics of degree 0) are entries of tables of 256; opacities have 8 bits.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Whole
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.file_format import FileFormat, ReadSplats
from hgs_core.interchange.sog_writer import FIRST_TAG, META, OTHERS, SOG_BYTES, sog_file
from hgs_core.interchange.splat_properties import SH_0
from hgs_core.scene.opacities import logits_of_any
from hgs_core.scene.splats import StaticSplats

__all__ = ["SOG", "read_sog"]

LARGEST_PART = 1 << 30  # bytes of a file in the zip
LARGEST_PICTURE = 1 << 26  # pixels: splats
_CURE = "save it as .sog again"


def read_sog(path: Path) -> ReadSplats:
    """Read a .sog file, or the folder of a `meta.json`.

    Raises:
        InputError: a part is missing or damaged, or the file is of another version.
    """
    parts = _folder_parts(path) if path.is_dir() else _zip_parts(path)
    meta = _meta(path, parts)
    count = meta["count"]
    try:
        return _read(path, parts, meta, count)
    except (KeyError, TypeError, IndexError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, f"has a {META} without what splats need ({error})", _CURE) from error


def _read(path: Path, parts: Mapping[str, bytes], meta: dict[str, Any], count: int) -> ReadSplats:
    low, high = (_pixels(path, parts, meta["means"]["files"][i], count)[:, :3].astype(np.int64) for i in (0, 1))
    mins, maxs = (_three(meta["means"][end]) for end in ("mins", "maxs"))
    logarithms = mins + (maxs - mins) * ((low + 256 * high) / 65535)
    means = np.sign(logarithms) * np.expm1(np.abs(logarithms))
    scales = _pixels(path, parts, meta["scales"]["files"][0], count)
    colours = _pixels(path, parts, meta["sh0"]["files"][0], count)
    quats = _rotations(_pixels(path, parts, meta["quats"]["files"][0], count))
    with np.errstate(over="ignore"):
        splats = StaticSplats(
            means.astype(np.float32),
            _table(meta["scales"]["codebook"])[scales[:, :3]].astype(np.float32),
            quats.astype(np.float32),
            logits_of_any(colours[:, 3] / 255),
            (0.5 + SH_0 * _table(meta["sh0"]["codebook"])[colours[:, :3]]).astype(np.float32),
        )
    changes = []
    if "shN" in meta:
        reason = "spherical harmonics above degree 0: colours are the same from every direction"
        changes.append(Change(Action.LEFT_OUT, "view-dependent colour", count, count, reason))
    said = meta.get("antialias")
    return ReadSplats(splats, antialiased=said if isinstance(said, bool) else None, changes=tuple(changes))


def _zip_parts(path: Path) -> Mapping[str, bytes]:
    data = file_bytes(path, "a .sog file")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            parts = {}
            for entry in archive.infolist():
                if entry.file_size > LARGEST_PART:
                    raise InputError(path, f"holds {entry.filename} of {entry.file_size:,} bytes", "split the scene")
                parts[Path(entry.filename).name] = archive.read(entry)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, f"is no .sog file that can be unpacked ({error})", "copy it again") from error
    return parts


def _folder_parts(folder: Path) -> Mapping[str, bytes]:
    files = [file for file in folder.iterdir() if file.name == META or file.suffix == ".webp"]
    return {file.name: file_bytes(file, "a part of a SOG scene") for file in files}


def _meta(path: Path, parts: Mapping[str, bytes]) -> dict[str, Any]:
    if META not in parts:
        raise InputError(path, f"holds no {META}", _CURE)
    try:
        meta = json.loads(parts[META])
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"has a {META} that is no JSON", _CURE) from error
    if not isinstance(meta, dict) or meta.get("version") != 2:
        said = meta.get("version", "1 or none") if isinstance(meta, dict) else "none"
        source = path / META if path.is_dir() else path
        cure = f"npx @playcanvas/splat-transform {source.name} {path.stem}.ply, and import that"
        raise InputError(path, f"is SOG of version {said}, and version 2 is read", cure)
    count = meta.get("count")
    if type(count) is not int or not 0 <= count <= LARGEST_PICTURE:
        raise InputError(path, f"says that it holds {str(count)[:40]} splats", _CURE)
    return meta


def _pixels(path: Path, parts: Mapping[str, bytes], name: object, count: int) -> NDArray[np.uint8]:
    """Return the first pixels of a picture [count, 4]."""
    from PIL import Image  # not above: `hgs serve` loads this module, and no library that opens pictures

    if not isinstance(name, str) or name not in parts:
        raise InputError(path, f"has no part {str(name)[:60]}, which its {META} names", "copy it again")
    try:
        with Image.open(io.BytesIO(parts[name]), formats=["WEBP"]) as picture:
            if not count <= picture.width * picture.height <= LARGEST_PICTURE:
                problem = f"has {name} of {picture.width} x {picture.height} pixels for {count} splats"
                raise InputError(path, problem, "copy it again")
            pixels = np.asarray(picture.convert("RGBA"))
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, f"has {name}, which is no whole WebP picture", "copy it again") from error
    return pixels.reshape(-1, 4)[:count]


def _three(values: Any) -> Doubles:
    found = np.array(values, np.float64)
    if found.shape != (3,):
        raise ValueError("bounds of positions are not three numbers")
    return found


def _table(values: Any) -> Doubles:
    found = np.array(values, np.float64)
    if found.shape != (256,):
        raise ValueError("a codebook has not 256 numbers")
    return found


def _rotations(pixels: NDArray[np.uint8]) -> Doubles:
    """Return quaternions w, x, y, z [N, 4]; without length where the tag names no component."""
    others = (pixels[:, :3] / 255 - 0.5) * np.sqrt(2)
    tags: Whole = pixels[:, 3].astype(np.int64) - FIRST_TAG
    rows, largest = np.arange(len(pixels)), np.maximum(tags, 0)
    quats = np.zeros((len(pixels), 4))
    quats[rows[:, None], OTHERS[largest]] = others
    quats[rows, largest] = np.sqrt(np.maximum(0.0, 1 - (others**2).sum(axis=1)))
    return np.where((tags < 0)[:, None], 0.0, quats)


SOG = FileFormat(".sog", read=lambda path, reading: read_sog(path), write_still=sog_file, frame_bytes=SOG_BYTES)
