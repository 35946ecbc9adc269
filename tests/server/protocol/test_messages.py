from __future__ import annotations

import struct

import msgpack

from server.protocol.messages import (
    HEADER_BYTES,
    End,
    Missing,
    Welcome,
    chunk_header,
    encode,
)


def test_server_messages_are_maps_of_their_fields() -> None:
    welcome = msgpack.unpackb(encode(Welcome(1, "studio", b"{}", bytes(32), 12)))
    assert welcome == {
        "type": "welcome",
        "protocol": 1,
        "scene": "studio",
        "manifest": b"{}",
        "manifest_id": bytes(32),
        "remaining": 12,
    }
    assert msgpack.unpackb(encode(Missing(bytes(32)))) == {"type": "missing", "id": bytes(32)}
    assert msgpack.unpackb(encode(End(7, 2))) == {"type": "end", "bytes": 7, "left_out": 2}


def test_chunk_header_is_laid_out_as_documented() -> None:
    chunk = bytes(range(32))
    header = chunk_header(chunk, 5, 70_000)
    assert len(header) == HEADER_BYTES == 48
    assert header[:4] == b"\x01\0\0\0"
    assert struct.unpack("<II", header[4:12]) == (5, 70_000)
    assert header[12:16] == bytes(4)
    assert header[16:] == chunk
