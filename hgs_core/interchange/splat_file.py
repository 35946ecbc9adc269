""".splat files (antimatter15): 32 bytes a splat, no header.

f32 x, y, z; f32 standard deviations; u8 r, g, b, opacity; u8 quaternion w, x, y, z as 128 + 128 q. Axes as ours.

There is no place for a note. Of splats that are drawn antialiased the last row is one that nobody sees (opacity 0), in
the place of the one before, whose colour and rotation spell that out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.antialiasing_note import noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.deviations import deviations_limited, deviations_of, log_scales_of
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.file_format import FileFormat, ReadSplats
from hgs_core.scene.opacities import logits_of_any, opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import StaticSplats

__all__ = ["SPLAT", "SPLAT_BYTES", "opacity_changes", "read_splat", "rgba_bytes", "rgba_changes", "splat_file"]

SPLAT_BYTES = 32
_ANTIALIASED = (np.frombuffer(b"hgs\0", np.uint8), np.frombuffer(b"aa=1", np.uint8))  # colour and opacity; rotation
_UNSEEN = 1e-9  # standard deviation of the row that says so
_ROW = np.dtype([("mean", "<f4", 3), ("deviation", "<f4", 3), ("rgba", "u1", 4), ("quat", "u1", 4)])


def rgba_bytes(rgb: Floats, opacity_logits: Floats) -> NDArray[np.uint8]:
    """Return colours and opacities [N, 4] as bytes."""
    opacity = opacities_of(opacity_logits)
    rgba = np.concatenate([rgb, opacity[:, None]], axis=1)
    return np.asarray(np.rint(np.clip(rgba, 0, 1) * 255), np.uint8)


def rgba_changes(rgb: Floats, opacity_logits: Floats, rgba: NDArray[np.uint8]) -> list[Change]:
    """Return the changes of colours and opacities by bytes [N, 4]."""
    return [
        Change.where(Action.LIMITED, "colour", (rgb < 0) | (rgb > 1), "to 0 to 1"),
        Change.rounded("colour", np.clip(rgb, 0, 1), rgba[:, :3] / 255, "8 bits a channel"),
        *opacity_changes(opacity_logits, rgba[:, 3]),
    ]


def opacity_changes(opacity_logits: Floats, stored: NDArray[np.uint8]) -> list[Change]:
    """Return the changes of opacities by bytes [N]."""
    opacity = opacities_of(opacity_logits)
    gone = (stored == 0) & (opacity > 0)
    return [
        Change.rounded("opacity", np.where(gone, 0.0, opacity), stored / 255, "8 bits"),
        Change.where(Action.REPLACED, "opacity", gone, "by 0, as it is below 1/510: they vanish"),
    ]


def splat_file(splats: StaticSplats[Floats], antialiased: bool = False) -> Written:
    """Return the file; large and opaque splats come first, so that a beginning of it shows most."""
    rows = np.zeros(len(splats), _ROW)
    rows["mean"], rows["deviation"] = splats.means, deviations_of(splats.log_scales)
    rows["rgba"] = rgba_bytes(splats.rgb, splats.opacity_logits)
    quats = unit_quaternions(splats.quats)
    rows["quat"] = np.clip(np.rint(quats * 128 + 128), 0, 255)
    shown = splats.log_scales.astype(np.float64).sum(axis=1) + np.log(rows["rgba"][:, 3] + 1e-3)
    note = noted_for_us(antialiased)
    changes = (
        *([] if note is None else [note]),
        deviations_limited(splats.log_scales),
        *rgba_changes(splats.rgb, splats.opacity_logits, rows["rgba"]),
        Change.rounded("rotation", quats, (rows["quat"].astype(np.float64) - 128) / 128, "8 bits a component"),
    )
    rows = rows[np.argsort(-shown, kind="stable")]
    if antialiased:
        last = np.zeros(1, _ROW)
        last["mean"] = rows["mean"][-1:] if len(rows) else 0.0
        last["deviation"] = _UNSEEN
        last["rgba"], last["quat"] = _ANTIALIASED
        rows = np.concatenate([rows, last])
    return Written(rows.tobytes(), changes)


def read_splat(path: Path) -> ReadSplats:
    """Read a .splat file.

    Raises:
        InputError: the file is missing, or not made of whole splats.
    """
    data = file_bytes(path, "a .splat file")
    if len(data) % SPLAT_BYTES or not data:
        raise InputError(path, f"has {len(data)} bytes, no multiple of {SPLAT_BYTES}", "copy it again")
    rows = np.frombuffer(data, _ROW)
    antialiased = all((rows[name][-1] == word).all() for name, word in zip(("rgba", "quat"), _ANTIALIASED, strict=True))
    rows = rows[: len(rows) - antialiased]
    splats = StaticSplats(
        rows["mean"].copy(),
        log_scales_of(rows["deviation"]),
        (rows["quat"].astype(np.float32) - 128) / 128,
        logits_of_any(rows["rgba"][:, 3] / 255),
        rows["rgba"][:, :3].astype(np.float32) / 255,
    )
    return ReadSplats(splats, antialiased=True if antialiased else None)


SPLAT = FileFormat(".splat", read=lambda path, reading: read_splat(path), write_still=splat_file)
