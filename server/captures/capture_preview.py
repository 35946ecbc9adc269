"""The pictures of a capture and the prices of its trainings, for the form of a new scene.

For the limited process of `server.captures.capture_reader` alone.
"""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.first_picture import first_picture
from hgs_core.runs.run_config import PRESETS, RunConfig
from hgs_core.runs.training_costs import scene_bytes, training_need
from hgs_core.runs.training_size import TrainingSize

__all__ = ["camera_picture", "capture_preview", "training_prices"]

_MOST_FRAMES = 1 << 20  # frames of a camera, ten hours; a header that announces more is wrong
_PICTURE_SIZE = (192, 144)  # pixels at most
_PICTURE_QUALITY = 75  # JPEG


def capture_preview(first: Path, cameras: int, frames: int | None, seconds: float | None) -> dict[str, Any]:
    """Return `picture` and `presets` of a capture; each null where it cannot be told.

    Args:
        first: first camera's video or first picture.
        cameras: number of cameras.
        frames: of a camera, if known.
        seconds: duration of the frames, if known.
    """
    try:
        picture = Image.fromarray(first_picture(first))
    except InputError:  # a job's check reports it with its cure
        return {"picture": None, "presets": None}
    pixels = picture.width * picture.height
    prices = None
    if frames is not None and seconds is not None and _counts(frames, seconds):
        prices = training_prices(cameras, frames, seconds, pixels)
    return {"picture": _small(picture), "presets": prices}


def camera_picture(file: Path) -> str | None:
    """Return the first picture of a camera as a data URI, or null where it cannot be decoded."""
    try:
        return _small(Image.fromarray(first_picture(file)))
    except InputError:
        return None


def _small(picture: Image.Image) -> str:
    picture.thumbnail(_PICTURE_SIZE)
    data = io.BytesIO()
    picture.save(data, "JPEG", quality=_PICTURE_QUALITY)
    return f"data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}"


def _counts(frames: int, seconds: float) -> bool:
    """Return whether a header's length is one that a training can have."""
    return frames == 1 or (1 < frames <= _MOST_FRAMES and 0 < seconds < float("inf"))


def training_prices(cameras: int, frames: int, seconds: float, pixels: int) -> dict[str, Any]:
    """Return the minutes on this machine and the bytes of the scene, both predicted, by preset."""
    prices = {}
    for preset in PRESETS:
        config = RunConfig.for_preset(preset)
        size = TrainingSize.announced(cameras, frames, seconds, pixels, config)
        need = training_need(size, config)
        prices[preset] = {"minutes": sum(need.seconds().values()) / 60, "bytes": scene_bytes(size)}
    return prices
