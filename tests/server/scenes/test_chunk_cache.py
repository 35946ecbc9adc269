from __future__ import annotations

import asyncio
import hashlib
import logging

import pytest

from server.scenes.chunk_cache import RETRY_SECONDS, ChunkCache
from server.scenes.scene_index import Chunk


class Store:
    def __init__(self, *chunks: bytes) -> None:
        self.chunks = {hashlib.sha256(data).hexdigest(): data for data in chunks}
        self.reads: list[str] = []

    def read(self, chunk_id: str) -> bytes | None:
        self.reads.append(chunk_id)
        return self.chunks.get(chunk_id)


def test_least_recently_used_chunks_make_room() -> None:
    store = Store(b"a" * 40, b"b" * 40, b"c" * 40)
    a, b, c = store.chunks

    async def scenario() -> None:
        cache = ChunkCache(store.read, capacity=100)
        for chunk in (a, b, a, c):  # c pushes b out, since a was used later
            assert await cache.get(chunk) == store.chunks[chunk]
        assert cache.size == 80
        await cache.get(a)
        await cache.get(b)

    asyncio.run(scenario())
    assert store.reads == [a, b, c, b]


def test_chunk_larger_than_the_cache_is_served_and_not_kept() -> None:
    store = Store(b"x" * 200)
    (chunk,) = store.chunks

    async def scenario() -> None:
        cache = ChunkCache(store.read, capacity=100)
        assert await cache.get(chunk) == b"x" * 200
        assert cache.size == 0

    asyncio.run(scenario())


def test_concurrent_callers_share_one_read() -> None:
    store = Store(b"data")
    (chunk,) = store.chunks

    async def scenario() -> None:
        cache = ChunkCache(store.read)
        assert await asyncio.gather(*(cache.get(chunk) for _ in range(5))) == [b"data"] * 5

    asyncio.run(scenario())
    assert len(store.reads) == 1


def test_cancelled_caller_does_not_cancel_the_read_for_others() -> None:
    store = Store(b"data")
    (chunk,) = store.chunks

    async def scenario() -> None:
        cache = ChunkCache(store.read)
        first, second = (asyncio.create_task(cache.get(chunk)) for _ in range(2))
        await asyncio.sleep(0)
        first.cancel()
        assert await second == b"data"

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("stored", "size", "fault"),
    [(None, 4, "not in the store"), (b"dat\0", 4, "another SHA-256"), (b"data", 5, "but the manifest lists 5")],
)
def test_fault_is_logged_once_and_the_store_is_asked_again_later(
    stored: bytes | None, size: int, fault: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    store = Store(b"data")
    (name,) = store.chunks
    right = store.chunks.pop(name)
    if stored is not None:
        store.chunks[name] = stored
    now = 100.0

    async def scenario() -> None:
        nonlocal now
        cache = ChunkCache(store.read, clock=lambda: now)
        chunk = Chunk(bytes.fromhex(name), size)
        assert await asyncio.gather(*(cache.expect(chunk) for _ in range(3))) == [None] * 3
        now += RETRY_SECONDS - 1
        assert await cache.expect(chunk) is None
        assert len(store.reads) == 1
        now += 2
        assert await cache.expect(chunk) is None
        assert [record.levelname for record in caplog.records] == ["ERROR"]
        assert name in caplog.text
        assert fault in caplog.text
        store.chunks[name] = right
        now += RETRY_SECONDS
        assert await cache.expect(Chunk(chunk.id, 4)) == b"data"

    asyncio.run(scenario())
