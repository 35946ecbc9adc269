"""Pictures of the cameras of a capture, for the choice of those that check the scene.

A separate process decodes them (`server.captures.capture_reader`), for one capture at a time. They are cached until a
file of the capture changes.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from server.captures.capture_folders import CaptureFolders
from server.captures.capture_readers import CaptureReaders, ReaderEndedError, answered
from server.captures.reading_cache import KEPT_SECONDS, ReadingCache, files_mark
from server.http.problem_error import ProblemError

__all__ = ["CameraPictures"]

_MOST_WAITING = 20  # captures
_MOST_KEPT = 64 << 20  # bytes of pictures
_SECONDS = 20  # processor time per capture
_WALL_SECONDS = 60.0  # wall time per camera


class CameraPictures:
    """Decodes the first picture of each camera; for one event loop."""

    def __init__(self, folders: CaptureFolders, readers: CaptureReaders) -> None:
        """Read nothing yet."""
        self._folders, self._readers = folders, readers
        self._thread = ThreadPoolExecutor(1, "pictures")
        self._under_way: dict[str, asyncio.Future[dict[str, str | None]]] = {}
        self._kept = ReadingCache[dict[str, str | None]](_MOST_KEPT)

    async def of(self, capture: Path) -> dict[str, str | None]:
        """Return the pictures as data URIs by camera, null for an unreadable one; callers of one capture share them.

        Cameras after a limit or a crash are missing.

        Raises:
            InputError: it is no capture.
            ProblemError: a link of it leads outside the folders; 503, too many captures are waiting.
        """
        key = f"{capture} {await asyncio.to_thread(files_mark, capture)}"
        kept = self._kept.get(key)
        if kept is not None:
            return kept
        reading = self._under_way.get(key)
        if reading is None:
            if len(self._under_way) >= _MOST_WAITING:
                detail = f"the pictures of {len(self._under_way)} captures are being read; try again later"
                raise ProblemError(503, "server-busy", detail, headers={"Retry-After": "10"})
            reading = asyncio.get_running_loop().run_in_executor(self._thread, self._read, capture, key)
            self._under_way[key] = reading
            reading.add_done_callback(lambda _: self._under_way.pop(key))
        return await asyncio.shield(reading)  # a caller that leaves must not cancel those of the others

    def close(self) -> None:
        """Start no further work; running work ends with the readers."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _read(self, capture: Path, key: str) -> dict[str, str | None]:
        request = self._folders.to_json() | {"capture": str(capture), "seconds": _SECONDS}
        pictures: dict[str, str | None] = {}
        seconds = float("inf")
        try:
            for answer in self._readers.read("pictures", request, _WALL_SECONDS):
                found = answered(answer, capture)
                pictures[found["camera"]] = found["picture"]
        except ReaderEndedError:
            seconds = KEPT_SECONDS  # the check of a job names the file
        size = sum(len(camera) + len(picture or "") for camera, picture in pictures.items())
        self._kept.keep(key, pictures, size, seconds)
        return pictures
