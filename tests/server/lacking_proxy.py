"""A proxy before a server that passes HTTP on, but no WebSocket."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import hashlib
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Literal

Lack = Literal["no upgrade", "200", "400", "502", "hang up", "drop", "swallow"]


@asynccontextmanager
async def lacking_proxy(server: int, lack: Lack, most: int | None = None) -> AsyncIterator[int]:
    """Gives its port. At most so many WebSockets are treated so, by default all of them."""
    treated = 0

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal treated
        with contextlib.suppress(OSError, asyncio.IncompleteReadError), contextlib.closing(writer):
            head = await reader.readuntil(b"\r\n\r\n")
            if b"upgrade: websocket" in head.lower() and (most is None or treated < most):
                treated += 1
                if lack != "no upgrade":
                    await _treat(head, reader, writer, lack)
                    return
                head = re.sub(rb"(?im)^(?:upgrade|connection): .*\r\n", b"", head)
            head = head.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n") if b"pgrade" not in head else head
            theirs, ours = await asyncio.open_connection("127.0.0.1", server)
            with contextlib.closing(ours):
                ours.write(head)
                await asyncio.gather(_pipe(reader, ours), _pipe(theirs, writer))

    listener = await asyncio.start_server(connected, "127.0.0.1", 0)
    try:
        yield int(listener.sockets[0].getsockname()[1])
    finally:
        listener.close()


async def _treat(head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, lack: Lack) -> None:
    if lack.isdigit():
        writer.write(f"HTTP/1.1 {lack} Anything\r\nContent-Length: 5\r\nConnection: close\r\n\r\nhello".encode())
    elif lack in ("drop", "swallow"):
        found = re.search(rb"(?i)sec-websocket-key: *(\S+)", head)
        assert found is not None
        accept = base64.b64encode(hashlib.sha1(found[1] + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
        writer.write(b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n")
        writer.write(b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n")
        await writer.drain()
        if lack == "swallow":
            while await reader.read(1 << 16):
                pass
    with contextlib.suppress(OSError):
        await writer.drain()


async def _pipe(source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while data := await source.read(1 << 16):
            sink.write(data)
            await sink.drain()
    with contextlib.suppress(OSError):
        sink.close()
