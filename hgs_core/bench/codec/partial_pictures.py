"""The loss of pictures while a part of a scene's chunks is missing."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import torch

from hgs_core.codec.format.decode import DecodedChunk, decode_chunk
from hgs_core.codec.format.manifest import Manifest
from hgs_core.render import rasterize
from hgs_core.scene.splats import joined

__all__ = ["partial_psnr"]

LONGEST_SIDE = 512  # pixels
CAMERAS = 3  # cameras of the scene, evenly chosen
BEST = 99.0  # dB, of pictures that are the same


def partial_psnr(
    manifest: Manifest, chunks: Mapping[str, bytes], shown: Sequence[tuple[float, Collection[str]]]
) -> list[float]:
    """Return the PSNR (dB, at most 99) of pictures that lack chunks against whole ones, one for each of `shown`.

    `shown` are seconds of the scene with the ids of the chunks that are there.
    """
    decoded = {entry.id: decode_chunk(chunks[entry.id]) for entry in manifest.chunks}
    step = max(1, len(manifest.cameras) // CAMERAS)
    cameras = [camera.within(LONGEST_SIDE) for camera in manifest.cameras[::step][:CAMERAS]]
    found = []
    for time, have in shown:
        errors = []
        for camera in cameras:
            whole = _picture(manifest, decoded, time, camera, None)
            errors.append(float(((_picture(manifest, decoded, time, camera, have) - whole) ** 2).mean()))
        mean = float(np.mean(errors))
        found.append(BEST if mean == 0 else min(BEST, -10 * math.log10(mean)))
    return found


def _picture(
    manifest: Manifest, decoded: Mapping[str, DecodedChunk], time: float, camera: Any, have: Collection[str] | None
) -> torch.Tensor:
    piece = [piece for piece in manifest.slices if piece.start <= time or piece is manifest.slices[0]][-1]
    segment = manifest.segments[piece.segment]
    length = segment.end - segment.start
    still = [decoded[entry.id].static() for entry in manifest.static if have is None or entry.id in have]
    names = (*piece.needs, *(entry.id for entry in piece.chunks))
    moving = [decoded[name].dynamic() for name in names if have is None or name in have]
    with torch.no_grad():
        return rasterize(
            joined(still).map(torch.from_numpy) if still else None,
            joined(moving).map(torch.from_numpy) if moving else None,
            camera,
            (time - segment.start) / length if length > 0 else 0.0,
            background=manifest.background,
            antialiased=manifest.antialiased,
            rig=manifest.rig,
        ).rgb
