"""Where the pixels of a straight picture lie on the sensor: found once for a camera, and used for all its pictures."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_count
from hgs_core.capture.lenses.lens import Lens
from hgs_core.native import library
from hgs_core.native.resampling import resampled
from hgs_core.scene.camera import Camera

__all__ = ["SensorPlaces", "sensor_places"]

_STRIP_PIXELS = 1 << 18  # pixels at a time, so that little memory is needed
_MOST_KEPT = 1 << 28  # bytes; more where every core reads another camera

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class SensorPlaces:
    """The four pixels of the photograph that each of N pixels is blended of, 12 bytes each."""

    corners: npt.NDArray[np.int32]  # [N] number of the upper left one
    right: npt.NDArray[np.float32]  # [N] share of the right ones
    lower: npt.NDArray[np.float32]  # [N] share of the lower ones

    @property
    def nbytes(self) -> int:
        """Bytes of the arrays."""
        return self.corners.nbytes + self.right.nbytes + self.lower.nbytes

    def blended(self, picture: Bytes) -> Bytes:
        """Return the colours [N, C] of a photograph [H, W, C] at the places, by bilinear interpolation."""
        if library.available():
            return resampled(np.ascontiguousarray(picture), self.corners, self.right, self.lower)
        result = np.empty((len(self.corners), picture.shape[2]), np.uint8)
        for first in range(0, len(result), _STRIP_PIXELS):
            strip = slice(first, first + _STRIP_PIXELS)
            result[strip] = self._blended_strip(picture, strip)
        return result

    def _blended_strip(self, picture: Bytes, strip: slice) -> Bytes:
        width, channels = picture.shape[1:]
        flat, first = picture.reshape(-1, channels), self.corners[strip]
        right, lower = self.right[strip, None], self.lower[strip, None]

        def blend(offset: int) -> npt.NDArray[np.float32]:
            colours: npt.NDArray[np.float32] = flat.take(first + offset, axis=0).astype(np.float32)
            colours += right * (flat.take(first + offset + 1, axis=0) - colours)
            return colours

        upper = blend(0)
        upper += lower * (blend(width) - upper) + np.float32(0.5)
        return upper.astype(np.uint8)


_Key = tuple[Lens, tuple[float, ...], tuple[float, ...]]
_KEPT: OrderedDict[_Key, SensorPlaces] = OrderedDict()
_LOCK = threading.Lock()


def sensor_places(bent: Camera, lens: Lens, straight: Camera) -> SensorPlaces:
    """Return the places of a straight picture's pixels, row by row; those of the last cameras are kept.

    At least as many are kept as there are cores. A pixel that rounding puts outside the photograph lies on its edge.
    """
    key = lens, _geometry(bent), _geometry(straight)
    with _LOCK:
        if key in _KEPT:
            _KEPT.move_to_end(key)
            return _KEPT[key]
    places = _found(bent, lens, straight)
    with _LOCK:
        _KEPT[key] = places
        while len(_KEPT) > core_count() and sum(kept.nbytes for kept in _KEPT.values()) > _MOST_KEPT:
            _KEPT.popitem(last=False)
    return places


def _geometry(camera: Camera) -> tuple[float, ...]:
    return camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy


def _found(bent: Camera, lens: Lens, straight: Camera) -> SensorPlaces:
    count, width = straight.width * straight.height, straight.width
    corners, right, lower = np.empty(count, np.int32), np.empty(count, np.float32), np.empty(count, np.float32)
    x = ((np.arange(width) + 0.5 - straight.cx) / straight.fx).astype(np.float32)
    y = ((np.arange(straight.height) + 0.5 - straight.cy) / straight.fy).astype(np.float32)
    rows = max(1, _STRIP_PIXELS // width)
    for first in range(0, straight.height, rows):
        strip = slice(first * width, (first + rows) * width)
        u, v = lens.apply(*np.broadcast_arrays(x, y[first : first + rows, None]))
        column = np.clip(u * bent.fx + bent.cx - 0.5, 0, bent.width - 1).ravel()
        row = np.clip(v * bent.fy + bent.cy - 0.5, 0, bent.height - 1).ravel()
        left, top = (
            np.minimum(column.astype(np.int32), bent.width - 2),
            np.minimum(row.astype(np.int32), bent.height - 2),
        )
        corners[strip] = top * bent.width + left
        right[strip], lower[strip] = column - left, row - top
    return SensorPlaces(corners, right, lower)
