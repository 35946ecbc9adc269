"""Chunks in memory: each is read from the store once, checked, and kept while there is room."""

from __future__ import annotations

import asyncio
import hashlib
from collections import OrderedDict
from collections.abc import Callable

from starlette.concurrency import run_in_threadpool

__all__ = ["ChunkCache", "DamagedChunkError"]


class DamagedChunkError(Exception):
    """The bytes in the store are not those that the chunk's id names."""


class ChunkCache:
    """A least-recently-used cache of chunks, at most `capacity` bytes; for one event loop."""

    def __init__(self, read: Callable[[str], bytes | None], capacity: int = 256 << 20) -> None:
        """Cache what `read` (blocking; None = no such chunk) returns for a chunk id of 64 hex digits."""
        self._read = read
        self._capacity = capacity
        self._chunks: OrderedDict[str, bytes] = OrderedDict()
        self._reads: dict[str, asyncio.Task[bytes | None]] = {}
        self._size = 0

    @property
    def size(self) -> int:
        """Bytes kept."""
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
        # A caller that is cancelled must not cancel the read for the others.
        return await asyncio.shield(task)

    def _forget(self, chunk_id: str, done: asyncio.Task[bytes | None]) -> None:
        self._reads.pop(chunk_id, None)
        if not done.cancelled():
            done.exception()  # looked at, so that asyncio does not complain when every caller has gone

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
        if data is not None and hashlib.sha256(data).hexdigest() != chunk_id:
            raise DamagedChunkError(f"chunk {chunk_id}: the stored bytes have another SHA-256")
        return data
