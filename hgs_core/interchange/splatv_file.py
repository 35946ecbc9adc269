""".splatv files (antimatter15, splaTV): a 4D scene as the texture that its viewer draws from, 64 bytes a splat.

u32 0x674b, u32 length of a JSON list of chunks, the list, the chunks. The one chunk is a texture of 4096 texels a row,
four texels of four u32 a splat: f32 x, y, z, and halves in pairs: quaternion (w, x, y, z), standard deviations, a pair
(unused, u8 r, g, b, opacity), nine motion coefficients, four of turning, centre and width of the life in [0, 1].
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.interchange.antialiasing_note import NOTE, noted_for_us
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.file_format import FileFormat
from hgs_core.interchange.ply.spacetime_ply import BRIEFEST, STEADIEST, life_limited
from hgs_core.interchange.splat_file import rgba_bytes, rgba_changes
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["SPLATV", "SPLATV_BYTES", "splatv_file"]

MAGIC = 0x674B
SPLATV_BYTES = 64
ROW_SPLATS = 1024
LARGEST_HALF = 65504.0
LARGEST_LOG_SCALE = 11.0  # its exponential fits a half
NARROWEST = 6e-5  # width of a life: halves below it lose precision
_ROW = np.dtype(
    [
        ("mean", "<f4", 3),
        ("quat", "<f2", 4),
        ("deviation", "<f2", 4),
        ("rgba", "u1", 4),
        ("motion", "<f2", 10),
        ("omega", "<f2", 4),
        ("clock", "<f2", 2),
    ]
)


def splatv_file(
    static: StaticSplats[Floats], dynamic: DynamicSplats[Floats], cameras: Sequence[Camera], antialiased: bool = False
) -> Written:
    """Return the file; the first camera is the one that the viewer starts from."""
    sets = [at_rest(static), dynamic]
    total = len(static) + len(dynamic)
    texture_rows = max(1, -(-total // ROW_SPLATS))
    rows = np.zeros(texture_rows * ROW_SPLATS, _ROW)
    rows["clock"][:, 1] = 1  # padding of the texture is transparent, without a division by zero
    at = 0
    for splats in sets:
        part = rows[at : at + len(splats)]
        at += len(splats)
        part["mean"] = splats.motion[:, 0]
        part["quat"] = _half(splats.rotation[:, 0])
        part["deviation"][:, :3] = _half(np.exp(np.minimum(splats.log_scales, LARGEST_LOG_SCALE)))
        part["rgba"] = rgba_bytes(splats.rgb, splats.opacity_logits)
        part["motion"][:, :9] = _half(splats.motion[:, 1:].reshape(-1, 9))
        part["omega"] = _half(splats.rotation[:, 1])
        width = np.exp(np.clip(splats.time_log_precisions / -2, BRIEFEST, STEADIEST))
        part["clock"] = _half(np.stack([splats.time_centers, np.maximum(width, NARROWEST)], axis=1))
    chunk = {
        "type": "splat",
        "size": rows.nbytes,
        "texwidth": 4 * ROW_SPLATS,
        "texheight": texture_rows,
        "cameras": [_camera(i, camera) for i, camera in enumerate(cameras)],
        NOTE: antialiased,
    }
    text = json.dumps([chunk], separators=(",", ":")).encode()
    data = np.array([MAGIC, len(text)], "<u4").tobytes() + text + rows.tobytes()
    note = noted_for_us(antialiased)
    return Written(data, (*([] if note is None else [note]), *_changes(static, dynamic, rows[:total])))


def _changes(static: StaticSplats[Floats], dynamic: DynamicSplats[Floats], rows: NDArray[np.void]) -> list[Change]:
    """Return the losses in the rows [N] of all splats, statics first."""
    halves = "16-bit floats"
    scales, rgb, logits = (
        np.concatenate([getattr(static, name), getattr(dynamic, name)])
        for name in ("log_scales", "rgb", "opacity_logits")
    )
    moving = rows[len(static) :]
    motion = dynamic.motion[:, 1:].reshape(-1, 9)
    limited = np.minimum(scales, LARGEST_LOG_SCALE)
    deviations = rows["deviation"][:, :3].astype(np.float64)
    return [
        Change.where(Action.LIMITED, "scale", scales > LARGEST_LOG_SCALE, f"to e^{LARGEST_LOG_SCALE:g}"),
        Change.rounded("scale", np.ones_like(limited), deviations / np.exp(limited.astype(np.float64)), halves),
        Change.rounded("rotation", np.concatenate([static.quats, dynamic.rotation[:, 0]]), rows["quat"], halves),
        *rgba_changes(rgb, logits, rows["rgba"]),
        life_limited(dynamic, float(np.log(NARROWEST))),
        Change.where(Action.LIMITED, "motion", np.abs(motion) > LARGEST_HALF, f"to coefficients of {LARGEST_HALF:g}"),
        Change.rounded("motion", np.clip(motion, -LARGEST_HALF, LARGEST_HALF), moving["motion"][:, :9], halves),
        Change.rounded("turning", dynamic.rotation[:, 1], moving["omega"], halves),
        Change.rounded("middle of life", dynamic.time_centers, moving["clock"][:, 0], halves),
    ]


def _half(values: Floats) -> NDArray[np.float16]:
    return np.asarray(np.clip(values, -LARGEST_HALF, LARGEST_HALF), np.float16)


def _camera(number: int, camera: Camera) -> dict[str, object]:
    """Describe a camera as 3DGS's cameras.json does: its place, and its axes in the world as columns."""
    return {
        "id": number,
        "img_name": camera.name,
        "width": camera.width,
        "height": camera.height,
        "position": camera.position.tolist(),
        "rotation": camera.world_to_camera[:3, :3].T.tolist(),
        "fx": camera.fx,
        "fy": camera.fy,
    }


SPLATV = FileFormat(".splatv", write_moving=splatv_file)
