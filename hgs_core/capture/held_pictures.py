"""The decoded pictures that a capture holds: in memory, or on disk where they do not all fit there."""

from __future__ import annotations

import threading
from collections.abc import Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import ProgressCallback
from hgs_core.base.version import software_version
from hgs_core.capture.decode_ahead import decode_ahead
from hgs_core.capture.pictures.picture_cache import FrameCache, Neighbour
from hgs_core.capture.pictures.picture_store import PictureStore
from hgs_core.scene.camera import Camera

__all__ = ["FrameSource", "HeldPictures", "shared_pictures"]

_MEMORY_BESIDE_DISK = 1 << 28  # bytes of pictures that are not on disk


class FrameSource(Protocol):
    """Where the pictures of a layout come from. Calls for the same camera never overlap; others may."""

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        """Return the picture [H, W, 3], and up to `neighbours` others that had to be decoded on the way."""

    def read_lines(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return the brightness [H, W] of the picture as its file has it, neither straightened nor reduced."""

    def read_mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_] | None:
        """Return the given motion mask [H, W], or None if the capture has none for this camera."""

    def mask_file(self, camera: int, frame: int) -> Path | None:
        """Return the file of a given mask, or None if the capture has none for this camera."""


class HeldPictures:
    """Pictures of cameras, decoded when asked for or ahead; safe to use from several threads."""

    def __init__(self, source: FrameSource, cameras: Sequence[Camera], frames: int, memory: int) -> None:
        """Hold nothing yet, and at most `memory` bytes of the pictures, `frames` of each camera."""
        self._source, self._cameras, self._memory = source, cameras, memory
        self._cache = FrameCache(memory)
        self._store: PictureStore | None = None
        self._locks = tuple(threading.Lock() for _ in cameras)
        self._sizes = [3 * camera.width * camera.height for camera in cameras]  # bytes
        self._wanted = frames * sum(self._sizes)  # bytes
        # Frames that were decoded only on the way to another are kept where all are; elsewhere they would only cost the
        # time of making pictures of them, and the place of those that are wanted.
        self._neighbours = frames if self._wanted <= memory else 0

    @property
    def bytes_in_memory(self) -> int:
        """Bytes of the pictures held in memory now."""
        return self._cache.bytes_held

    @property
    def room(self) -> int:
        """Bytes of pictures that can be held for random access.

        A decoder may pass pictures that nobody asks for: a fifth of the memory is theirs.
        """
        return self._memory * 4 // 5 if self._store is None else self._store.limit

    def keep_on_disk(self, folder: Path, limit: int, fingerprint: str) -> None:
        """Hold at most `limit` bytes of pictures in a folder from now on, those of this fingerprint that it has too.

        Nothing changes where all pictures fit in memory, or the folder may hold no more.

        Raises:
            InputError: the folder cannot be read.
        """
        if self.room >= min(self._wanted, limit):
            return
        sizes = [(camera.width, camera.height) for camera in self._cameras]
        self._store = PictureStore(folder, limit, f"{fingerprint} {sizes} {software_version()}")
        self._cache = FrameCache(min(self._memory, _MEMORY_BESIDE_DISK))
        self._neighbours = 0

    def picture(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return a picture [H, W, 3], read-only.

        Raises:
            InputError: it is missing, unreadable or of another size than its camera's.
        """
        picture = self._cache.get(camera, frame)
        if picture is None and self._store is not None:
            picture = self._store.read(camera, frame, self._cameras[camera].height, self._cameras[camera].width)
        if picture is not None:
            return picture
        with self._locks[camera]:
            picture = self._cache.get(camera, frame)  # another thread may have decoded it while this one waited
            if picture is None:
                picture, passed = self._source.read(camera, frame, self._neighbours)
                for index, neighbour in passed:
                    self._cache.put(camera, index, neighbour)
                picture.flags.writeable = False
                self._cache.put(camera, frame, picture)
        return picture

    def lines(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return the brightness [H, W] of a picture as its file has it; it is not held.

        Raises:
            InputError: it is missing or unreadable.
        """
        with self._locks[camera]:
            return self._source.read_lines(camera, frame)

    def hold(self, cameras: Sequence[int], frames: Sequence[int], progress: ProgressCallback) -> None:
        """Decode pictures ahead, on all cores; nothing is done where they do not fit.

        Raises:
            InputError: as `picture`, or the disk is full.
            StageStopped: the callback wishes so.
        """
        if len(frames) * sum(self._sizes[index] for index in cameras) > self.room:
            return
        held = self._cache if self._store is None else self._store
        missing = {index: [frame for frame in frames if (index, frame) not in held] for index in cameras}
        missing = {index: own for index, own in missing.items() if own}
        if not missing:
            return
        if self._store is None:
            decode_ahead(missing, self.picture, progress)
            return
        needed = sum(self._sizes[index] * len(own) for index, own in missing.items())
        self._store.make_room(needed, {(index, frame) for index in cameras for frame in frames})
        decode_ahead(missing, self._onto_disk, progress)

    def expect(self, pictures: Iterable[tuple[int, int]]) -> None:
        """Have pictures (camera, frame) that are on disk read into the system's memory meanwhile."""
        if self._store is not None:
            self._store.expect(pictures)

    @classmethod
    def shared(
        cls, key: Hashable, source: FrameSource, cameras: Sequence[Camera], frames: int, memory: int
    ) -> HeldPictures:
        """Return the pictures that are held under `key` within `shared_pictures`, or new ones.

        Sources of one key must give equal pictures. Pictures that do not all fit in memory are not shared: a disk does
        that.
        """
        new, held = cls(source, cameras, frames, memory), _shared.get()
        return new if held is None or new._wanted > memory else held.setdefault(key, new)

    def _onto_disk(self, camera: int, frame: int) -> None:
        assert self._store is not None
        with self._locks[camera]:
            picture, _ = self._source.read(camera, frame, 0)
        self._store.write(camera, frame, picture)


_shared: ContextVar[dict[Hashable, HeldPictures] | None] = ContextVar("shared_pictures", default=None)


@contextmanager
def shared_pictures() -> Iterator[None]:
    """Let equal captures that are opened meanwhile hold their pictures together, so that each is decoded once."""
    before = _shared.set({})
    try:
        yield
    finally:
        _shared.reset(before)
