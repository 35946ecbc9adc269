"""Cache of chunks: each is read from the store once, verified, and kept while there is room."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import OrderedDict
from collections.abc import Callable

from starlette.concurrency import run_in_threadpool

from hgs_core.codec.format.scene_folder import chunk_id as content_id
from server.scenes.scene_index import Chunk

__all__ = ["ChunkCache", "DamagedChunkError"]

log = logging.getLogger("hgs.server")

RETRY_SECONDS = 30.0  # pause before the store is asked again for a missing chunk


class DamagedChunkError(Exception):
    """The stored bytes do not match the chunk's id."""


class ChunkCache:
    """Least-recently-used cache of chunks, at most `capacity` bytes; for one event loop."""

    def __init__(
        self,
        read: Callable[[str], bytes | None],
        capacity: int = 256 << 20,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Cache the results of `read` (blocking; None = no such chunk) for chunk ids of 64 hex digits."""
        self._read = read
        self._capacity = capacity
        self._chunks: OrderedDict[str, bytes] = OrderedDict()
        self._reads: dict[str, asyncio.Task[bytes | None]] = {}
        self._faults: dict[str, float] = {}  # moments of failed reads, by chunk
        self._clock = clock
        self._size = 0

    @property
    def size(self) -> int:
        """Size of the cached chunks, bytes."""
        return self._size

    async def get(self, chunk_id: str) -> bytes | None:
        """Return the chunk's bytes, or None if the store has no such chunk. Concurrent callers share one read.

        Raises:
            DamagedChunkError: the stored bytes have another SHA-256.
        """
        data = self._chunks.get(chunk_id)
        if data is not None:
            self._chunks.move_to_end(chunk_id)
            return data
        task = self._reads.get(chunk_id)
        if task is None:
            task = asyncio.create_task(self._load(chunk_id))
            self._reads[chunk_id] = task
            task.add_done_callback(lambda done: self._forget(chunk_id, done))
        # A cancelled caller must not cancel the read for the others.
        return await asyncio.shield(task)

    async def expect(self, chunk: Chunk) -> bytes | None:
        """Return the bytes of a chunk named by a manifest, or None if the store does not have them.

        A fault is logged once. It may be temporary: the store is asked again after `RETRY_SECONDS`.
        """
        chunk_id = chunk.id.hex()
        failed = self._faults.get(chunk_id)
        if failed is not None and self._clock() - failed < RETRY_SECONDS:
            return None
        try:
            data = await self.get(chunk_id)
            fault = f"chunk {chunk_id}: not in the store"
        except DamagedChunkError as error:
            data, fault = None, str(error)
        if data is not None and len(data) != chunk.size:
            fault = f"chunk {chunk_id}: has {len(data)} bytes, but the manifest lists {chunk.size}"
            data = None
        if data is not None:
            if self._faults.pop(chunk_id, None) is not None:
                log.warning("chunk %s can be read again", chunk_id)
            return data
        if chunk_id not in self._faults:
            log.error("%s; scenes are shown without it", fault)
        self._faults[chunk_id] = self._clock()
        return None

    def _forget(self, chunk_id: str, done: asyncio.Task[bytes | None]) -> None:
        self._reads.pop(chunk_id, None)
        if not done.cancelled():
            done.exception()  # retrieved, so that asyncio does not warn when every caller has left

    async def _load(self, chunk_id: str) -> bytes | None:
        data = await run_in_threadpool(self._read_checked, chunk_id)
        if data is not None and len(data) <= self._capacity:
            self._chunks[chunk_id] = data
            self._size += len(data)
            while self._size > self._capacity:
                _, dropped = self._chunks.popitem(last=False)
                self._size -= len(dropped)
        return data

    def _read_checked(self, chunk_id: str) -> bytes | None:
        data = self._read(chunk_id)
        if data is not None and content_id(data) != chunk_id:
            raise DamagedChunkError(f"chunk {chunk_id}: the stored bytes have another SHA-256")
        return data
