"""Pictures inside a page, at the report's size."""

from __future__ import annotations

import base64
import io

import numpy as np
import numpy.typing as npt
from PIL import Image

__all__ = ["Bytes", "data_uri", "reduced", "reduced_size"]

Bytes = npt.NDArray[np.uint8]

_WIDTH = 640  # pixels, at most
_JPEG_QUALITY = 86  # JPEG


def reduced_size(width: int, height: int) -> tuple[int, int]:
    """Return the width and height that a picture has in the report, in pixels."""
    factor = min(1.0, _WIDTH / width)
    return max(1, round(width * factor)), max(1, round(height * factor))


def reduced(pixels: Bytes) -> Bytes:
    """Average a picture [H, W, 3] down to the report's size."""
    image = Image.fromarray(pixels)
    return np.asarray(image.resize(reduced_size(*image.size), Image.Resampling.BOX))


def data_uri(pixels: Bytes, quality: int = _JPEG_QUALITY) -> str:
    """Return a picture [H, W, 3] as a JPEG without colour subsampling, which would smear maps of colours."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=quality, subsampling=0, optimize=True)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()
