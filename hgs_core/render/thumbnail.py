"""The small picture by which a scene is recognised in a list."""

from __future__ import annotations

import dataclasses
import io
from typing import Any

import numpy as np
import torch
from PIL import Image

from hgs_core.render.scene_picture import pixels_of, scene_picture
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene, StaticSplats

__all__ = ["as_jpeg", "thumbnail", "thumbnail_size"]

_WIDTH = 480  # pixels
_QUALITY = 85  # JPEG


def thumbnail(
    scene: HybridScene[np.ndarray[Any, np.dtype[np.float32]]], camera: Camera, subject_only: bool = False
) -> bytes:
    """Return a JPEG of the scene at the middle of its time, seen from `camera`, 480 pixels wide at most.

    `subject_only` leaves out static splats, as viewers that begin without them do.
    """
    camera = thumbnail_size(camera)
    if subject_only:
        scene = dataclasses.replace(scene, static=StaticSplats.empty())
    return as_jpeg(scene_picture(scene.map(torch.from_numpy), camera, (scene.start + scene.end) / 2).rgb)


def thumbnail_size(camera: Camera) -> Camera:
    """Return the camera with pictures of 480 pixels' width at most."""
    return camera.scaled(min(1.0, _WIDTH / camera.width))


def as_jpeg(rgb: torch.Tensor) -> bytes:
    """Return a picture [3, H, W] of sRGB in [0, 1] as a JPEG file."""
    file = io.BytesIO()
    Image.fromarray(pixels_of(rgb)).save(file, "JPEG", quality=_QUALITY)
    return file.getvalue()
