"""Clients that a server on the internet has to bear with, and how long others wait meanwhile."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import socket
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from multiprocessing.synchronize import Event

import websockets
from websockets.asyncio.client import ClientConnection

from server.listener.connection_limits import raise_open_file_limit
from server.protocol.messages import HEADER_BYTES, MAX_BALANCE, MIN_PAYLOAD, PROTOCOL_VERSION, Hello, Ping, Seek, encode

__all__ = ["flooding", "idling", "pings", "resting", "stalled"]

PING_SECONDS = 0.02  # between two pings
SOCKETS_PER_ADDRESS = 1000
RECEIVE_BUFFER = 4096  # bytes, of a client that does not read


async def pings(url: str, seconds: float) -> list[float]:
    """Return how long the answers take, in seconds, that a viewer gets which has the scene and asks now and then."""
    async with websockets.connect(url, compression=None, max_size=None, ping_interval=None) as viewer:
        await viewer.send(encode(Hello(PROTOCOL_VERSION, MAX_BALANCE)))
        with contextlib.suppress(TimeoutError):  # the scene comes first
            while True:
                await asyncio.wait_for(viewer.recv(), 0.5)
        found = []
        begun = time.monotonic()
        while time.monotonic() - begun < seconds:
            asked = time.monotonic()
            await viewer.send(encode(Ping(1)))
            await viewer.recv()
            found.append(time.monotonic() - asked)
            await asyncio.sleep(PING_SECONDS)
        return found


@asynccontextmanager
async def stalled(url: str, readers: int) -> AsyncIterator[None]:
    """Open so many streams that ask for the whole scene and read nothing of it."""
    held: list[ClientConnection] = []
    host, _, port = url.split("/")[2].partition(":")
    try:
        for _ in range(readers):
            small = socket.socket()
            small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
            small.setblocking(False)
            await asyncio.get_running_loop().sock_connect(small, (host, int(port)))
            reader = await websockets.connect(url, sock=small, compression=None, ping_interval=None, max_size=None)
            reader.transport.pause_reading()
            held.append(reader)
            await reader.send(encode(Hello(PROTOCOL_VERSION, MAX_BALANCE)))
        yield
    finally:
        for reader in held:
            reader.transport.abort()


@contextmanager
def idling(port: int, sockets: int) -> Iterator[list[socket.socket]]:
    """Open so many connections, every second of which begins a request, and let them wait; from several addresses."""
    held: list[socket.socket] = []
    try:
        for place in range(sockets):
            one = socket.socket()
            held.append(one)
            one.settimeout(5)
            one.bind((f"127.0.1.{1 + place // SOCKETS_PER_ADDRESS}", 0))
            one.connect(("127.0.0.1", port))
            if place % 2:
                one.sendall(b"GET /v1/health HTTP/1.1\r\nHost: 127.0.0.1\r\nX-More: ")
        yield held
    finally:
        for one in held:
            one.close()


@contextmanager
def flooding(url: str, clients: int) -> Iterator[None]:
    """Let so many clients, in a process of their own, seek as often as they can."""
    process = multiprocessing.get_context("spawn").Process(target=_flood, args=(url, clients), daemon=True)
    process.start()
    try:
        yield
    finally:
        process.kill()
        process.join()


@contextmanager
def resting(url: str, viewers: int) -> Iterator[None]:
    """Let so many viewers, in a process of their own, take their first grant, ask for no more and stay."""
    spawn = multiprocessing.get_context("spawn")
    there = spawn.Event()
    process = spawn.Process(target=_rest, args=(url, viewers, there), daemon=True)
    process.start()
    try:
        there.wait()
        yield
    finally:
        process.kill()
        process.join()


def _rest(url: str, viewers: int, there: Event) -> None:
    raise_open_file_limit()

    async def rest() -> None:
        async with contextlib.AsyncExitStack() as held:
            for _ in range(viewers):
                socket = websockets.connect(url, compression=None, max_size=None, ping_interval=None)
                viewer = await held.enter_async_context(socket)
                await viewer.send(encode(Hello(PROTOCOL_VERSION, MIN_PAYLOAD + HEADER_BYTES)))
            there.set()
            await asyncio.Event().wait()

    asyncio.run(rest())


def _flood(url: str, clients: int) -> None:
    async def flood() -> None:
        await asyncio.gather(*(_seek(url) for _ in range(clients)))

    asyncio.run(flood())


async def _seek(url: str) -> None:
    async with websockets.connect(url, compression=None, max_size=None, ping_interval=None) as viewer:
        await viewer.send(encode(Hello(PROTOCOL_VERSION, MAX_BALANCE)))

        async def read() -> None:
            async for _ in viewer:
                pass

        reading = asyncio.create_task(read())
        while not reading.done():
            await viewer.send(encode(Seek(0.5)))
