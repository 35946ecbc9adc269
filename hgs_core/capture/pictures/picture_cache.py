"""The bounded store of decoded pictures."""

from __future__ import annotations

import mmap
import threading
from collections import OrderedDict

import numpy as np
import numpy.typing as npt

__all__ = ["FrameCache", "Neighbour"]

Neighbour = tuple[int, npt.NDArray[np.uint8]]
"""A frame index and its picture [H, W, 3]."""


_LARGE = 1 << 17  # bytes of a picture that is kept in memory of its own


class FrameCache:
    """Keeps the pictures that were used last, at most `limit` bytes of them; safe to use from several threads."""

    def __init__(self, limit: int) -> None:
        """Start empty; with a limit of 0 bytes nothing is ever kept."""
        self.limit = limit
        self._pictures: OrderedDict[tuple[int, int], npt.NDArray[np.uint8]] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    @property
    def bytes_held(self) -> int:
        """Bytes of the pictures held now."""
        return self._bytes

    def __contains__(self, picture: tuple[int, int]) -> bool:
        """Return whether the picture of a camera and frame is held."""
        return picture in self._pictures

    def get(self, camera: int, frame: int) -> npt.NDArray[np.uint8] | None:
        """Return the picture if it is held, and count it as used."""
        with self._lock:
            picture = self._pictures.get((camera, frame))
            if picture is not None:
                self._pictures.move_to_end((camera, frame))
            return picture

    def put(self, camera: int, frame: int, picture: npt.NDArray[np.uint8]) -> None:
        """Hold the picture, or a copy, made read-only; those that were used longest ago make room for it."""
        if _LARGE <= picture.nbytes <= self.limit:
            picture = _apart(picture)
        picture.flags.writeable = False
        with self._lock:
            if picture.nbytes > self.limit or (camera, frame) in self._pictures:
                return
            while self._bytes + picture.nbytes > self.limit:
                _, oldest = self._pictures.popitem(last=False)
                self._bytes -= oldest.nbytes
            self._pictures[camera, frame] = picture
            self._bytes += picture.nbytes


def _apart(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a copy in memory that goes back to the system with it.

    Large pictures that live long, among all that comes and goes beside them, would leave the heap full of holes: of two
    gigabytes of pictures it grew to five.
    """
    copy = np.frombuffer(mmap.mmap(-1, picture.nbytes), np.uint8).reshape(picture.shape)
    copy[...] = picture
    return copy
