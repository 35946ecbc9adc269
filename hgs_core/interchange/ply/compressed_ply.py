"""Compressed .ply files of PlayCanvas and SuperSplat: four words of 32 bits a splat, and bounds for every 256 splats.

Positions and logarithms of scales have 11, 10 and 11 bits between the bounds, colours and opacities 8 bits each
(colours between bounds, too, where the file has them), rotations the number of their largest component and 10 bits for
each of the others.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError
from hgs_core.interchange.ply.ply_table import Table, exact_columns
from hgs_core.interchange.splat_properties import DC, PLACE, ROT, SCALE, SH_0
from hgs_core.scene.opacities import logits_of_any

__all__ = ["PACKED", "is_compressed", "unpacked"]

PACKED = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
CHUNK = 256  # splats
_BOUNDS = {PLACE: ("x", "y", "z"), SCALE: ("scale_x", "scale_y", "scale_z"), DC: ("r", "g", "b")}
_OTHERS = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])  # components beside the largest one


def is_compressed(table: Table) -> bool:
    """Return whether a point cloud is packed."""
    return PACKED[0] in table


def unpacked(path: Path, table: Table, chunks: Table | None) -> dict[str, NDArray[Any]]:
    """Return the columns of a plain 3DGS file that a packed one stands for.

    Raises:
        InputError: a word is missing, or the bounds do not fit the splats.
    """
    for name in PACKED:
        if name not in table or table[name].dtype != np.uint32:
            raise InputError(path, f"has no vertex property uint {name}", "compress it again")
    count = len(table[PACKED[0]])
    if chunks is None or min(map(len, chunks.values()), default=0) != -(-count // CHUNK):
        there = 0 if chunks is None else min(map(len, chunks.values()), default=0)
        raise InputError(
            path, f"has bounds of {there} chunks, {count} splats need {-(-count // CHUNK)}", "copy it again"
        )
    position, rotation, scale, colour = (table[name] for name in PACKED)
    parts = {PLACE: _bits(position, (11, 10, 11)), SCALE: _bits(scale, (11, 10, 11))}
    rgba = _bits(colour, (8, 8, 8, 8))
    parts[DC] = rgba[:, :3]
    found: dict[str, NDArray[Any]] = {}
    for names, values in parts.items():
        if names != DC or "min_r" in chunks:
            low, high = (exact_columns(path, chunks, [f"{end}_{n}" for n in _BOUNDS[names]]) for end in ("min", "max"))
            values = _between(low, high, values)
        if names == DC:
            values = (values - 0.5) / SH_0
        found |= dict(zip(names, values.T, strict=True))
    found |= dict(zip(ROT, _rotations(rotation).T, strict=True))
    found["opacity"] = logits_of_any(rgba[:, 3])
    return {name: array.astype(np.float32) for name, array in found.items()}


def _bits(words: NDArray[np.uint32], widths: tuple[int, ...]) -> Doubles:
    """Return the parts of words [N] from the highest bits down, each 0 to 1, [N, C]."""
    shift, parts = sum(widths), []
    for width in widths:
        shift -= width
        parts.append(((words >> np.uint32(shift)) & np.uint32((1 << width) - 1)) / ((1 << width) - 1))
    return np.stack(parts, axis=1).astype(np.float64)


def _between(low: Doubles, high: Doubles, shares: Doubles) -> Doubles:
    """Return shares [N, 3] of the way between the bounds of each splat's chunk."""
    chunk = np.arange(len(shares)) // CHUNK
    return low[chunk] * (1 - shares) + high[chunk] * shares


def _rotations(words: NDArray[np.uint32]) -> Doubles:
    """Return quaternions w, x, y, z [N, 4]."""
    others = (_bits(words & np.uint32((1 << 30) - 1), (10, 10, 10)) - 0.5) * np.sqrt(2)
    largest = (words >> np.uint32(30)).astype(np.intp)
    quats = np.zeros((len(words), 4))
    rows = np.arange(len(words))
    quats[rows[:, None], _OTHERS[largest]] = others
    quats[rows, largest] = np.sqrt(np.maximum(0.0, 1 - (others**2).sum(axis=1)))
    return quats
