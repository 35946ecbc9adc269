"""The client's cached chunks, whole or in part, as listed in its hello."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

from server.protocol.messages import Hello, ProtocolError
from server.protocol.stream_endings import Closing
from server.scenes.scene_index import SceneIndex

__all__ = ["ClientCache"]


@dataclass(frozen=True)
class ClientCache:
    """Chunks of the scene that need not be sent, or not from their beginning."""

    whole: frozenset[bytes]
    parts: dict[bytes, int]  # bytes held of incomplete chunks

    @classmethod
    def of(cls, hello: Hello, scene: SceneIndex) -> ClientCache:
        """Return the cache described by a hello, without chunks of other scenes.

        Raises:
            ProtocolError: 4000, a part is not smaller than its chunk.
        """
        sizes = scene.stored
        parts = {chunk: offset for chunk, offset in hello.parts.items() if chunk in sizes and offset > 0}
        for chunk, offset in parts.items():
            if offset >= sizes[chunk]:
                detail = f"hello.parts: chunk {chunk.hex()} has {sizes[chunk]} bytes, not more than {offset}"
                raise ProtocolError(Closing.MALFORMED, detail)
        whole = {chunk for chunk in hello.have if chunk in sizes}
        for page, bits in hello.pages.items():
            if page in scene.page_chunks:
                whole.add(page)
                whole.update(_named(scene.page_chunks[page], bits))
        return cls(frozenset(whole), {chunk: offset for chunk, offset in parts.items() if chunk not in whole})

    def lacking(self, wanted: Mapping[bytes, int]) -> int:
        """Return how many bytes of these chunks, given with their sizes, are still to be sent."""
        there = sum(wanted.get(chunk, 0) for chunk in self.whole)
        there += sum(offset for chunk, offset in self.parts.items() if chunk in wanted)
        return sum(wanted.values()) - there


def _named(chunks: Iterable[bytes], bits: bytes) -> Iterator[bytes]:
    """Yield the chunks with a set bit, the lowest bit of each byte first."""
    for k, chunk in enumerate(islice(chunks, 8 * len(bits))):
        if bits[k // 8] >> k % 8 & 1:
            yield chunk
