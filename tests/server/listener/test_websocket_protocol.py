"""The protocol class alone: a transport and a clock that are the test's."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable
from typing import Any, cast

import pytest
import uvicorn
from uvicorn.server import ServerState

from server.listener.websocket_protocol import (
    MAX_FRAGMENTS,
    PIECE_BYTES,
    PING_BURST,
    STALL_CHECKS,
    STALL_SECONDS,
    WebSocketProtocol,
)

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: here\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def frame(opcode: int, payload: bytes = b"", *, final: bool = True) -> bytes:
    """A client's frame of less than 126 bytes, masked with zeros."""
    return bytes([opcode | (0x80 if final else 0), 0x80 | len(payload)]) + bytes(4) + payload


PING, PONG, MESSAGE = frame(0x9, b"x" * 100), 0xA, frame(0x2, b"message")


class Transport(asyncio.Transport):
    """A transport that keeps written bytes until the test removes them."""

    def __init__(self, connection: socket.socket | None) -> None:
        super().__init__({"socket": connection})
        self.waiting = 0
        self.written = b""
        self.aborted = False
        self.reading = True

    def write(self, data: Any) -> None:
        self.written += data

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        self.high = high

    def pause_reading(self) -> None:
        self.reading = False

    def resume_reading(self) -> None:
        self.reading = True

    def is_closing(self) -> bool:
        return self.aborted

    def close(self) -> None:
        pass  # waiting bytes would have to go first

    def abort(self) -> None:
        self.aborted = True


class Task:
    """Of the application; never ends."""

    def add_done_callback(self, callback: Callable[..., Any]) -> None:
        pass


class Loop:
    """A clock that stands until the test advances it."""

    def __init__(self) -> None:
        self.now = 0.0
        self.timers: list[asyncio.TimerHandle] = []

    def time(self) -> float:
        return self.now

    def call_later(self, delay: float, callback: Callable[..., Any], *arguments: Any) -> asyncio.TimerHandle:
        timer = asyncio.TimerHandle(self.now + delay, callback, arguments, cast(Any, self))
        self.timers.append(timer)
        return timer

    def _timer_handle_cancelled(self, timer: asyncio.TimerHandle) -> None:
        self.timers.remove(timer)

    def get_debug(self) -> bool:
        return False

    def create_task(self, coroutine: Any) -> Task:
        coroutine.close()  # the application is the test
        return Task()

    def advance(self, seconds: float) -> None:
        end = self.now + seconds
        while self.timers and (timer := min(self.timers, key=lambda timer: timer.when())).when() <= end:
            self.now = timer.when()
            self.timers.remove(timer)
            timer._run()
        self.now = end


class Connection:
    """An accepted WebSocket."""

    def __init__(self, connection: socket.socket | None = None) -> None:
        self.loop = Loop()
        self.transport = Transport(connection)
        config = uvicorn.Config(cast(Any, lambda: None), log_config=None)
        config.load()
        self.protocol = WebSocketProtocol(
            config=config, server_state=ServerState(), app_state={}, _loop=cast(Any, self.loop)
        )
        self.protocol.connection_made(self.transport)
        self.protocol.data_received(UPGRADE)
        self.run(self.protocol.receive())
        self.run(self.protocol.send({"type": "websocket.accept"}))

    def run(self, coroutine: Any) -> Any:
        """Run a coroutine that does not wait."""
        with pytest.raises(StopIteration) as stop:
            coroutine.send(None)
        return stop.value.value

    def receive_ping(self) -> bytes:
        """Return the payload of the keepalive ping that has just been written."""
        assert self.transport.written[-6:-4] == b"\x89\x04"
        return self.transport.written[-4:]


@pytest.fixture
def connection() -> Connection:
    return Connection()


def test_peer_that_takes_nothing_is_cut_off_in_time() -> None:
    """Whenever it ceases to, and not long before the time is up."""
    look = STALL_SECONDS / STALL_CHECKS
    for early in (0.0, 0.4 * look, 0.99 * look):
        stalled = Connection()
        stalled.protocol.pause_writing()  # something waits, and is taken
        stalled.protocol.resume_writing()
        stalled.loop.advance(early)
        stalled.transport.waiting = 5000
        stalled.protocol.pause_writing()
        stalled.loop.advance(STALL_SECONDS - look - 0.01)
        assert not stalled.transport.aborted
        stalled.loop.advance(look + 0.01)
        assert stalled.transport.aborted


def test_peer_that_ceases_to_take_is_cut_off_in_time(connection: Connection) -> None:
    connection.transport.waiting = 5000
    connection.protocol.pause_writing()
    connection.loop.advance(10)
    connection.transport.waiting = 4000
    connection.loop.advance(STALL_SECONDS - 2 * STALL_SECONDS / STALL_CHECKS)
    assert not connection.transport.aborted
    connection.loop.advance(2 * STALL_SECONDS / STALL_CHECKS)
    assert connection.transport.aborted


def test_peer_for_whom_nothing_waits_is_not_looked_at(connection: Connection) -> None:
    before = len(connection.loop.timers)
    connection.protocol.pause_writing()
    assert len(connection.loop.timers) == before + 1
    connection.protocol.resume_writing()
    connection.loop.advance(STALL_SECONDS / STALL_CHECKS)
    assert len(connection.loop.timers) == before


def test_peer_that_takes_little_by_little_is_not_cut_off(connection: Connection) -> None:
    """A manifest of megabytes takes minutes on a slow line, and pings behind it are not answered meanwhile."""
    connection.transport.waiting = 3_000_000
    connection.protocol.pause_writing()
    for _ in range(30):
        connection.loop.advance(10)
        connection.transport.waiting -= 50_000
    assert not connection.transport.aborted


def test_peer_that_takes_every_frame_slowly_is_not_cut_off(connection: Connection) -> None:
    for _ in range(30):
        connection.transport.waiting = 65_000  # a frame as long as the last one, which has gone meanwhile
        connection.protocol.pause_writing()
        connection.loop.advance(10)
        connection.protocol.resume_writing()
    assert not connection.transport.aborted


def test_silent_peer_is_cut_off(connection: Connection) -> None:
    connection.loop.advance(100)
    assert connection.transport.aborted


def test_peer_that_answers_pings_stays(connection: Connection) -> None:
    for _ in range(10):
        connection.loop.advance(20)
        connection.protocol.data_received(frame(PONG, connection.receive_ping()))
    assert not connection.transport.aborted


def test_peer_that_speaks_stays_while_its_pong_is_under_way(connection: Connection) -> None:
    for _ in range(30):
        connection.loop.advance(10)
        connection.protocol.data_received(MESSAGE)
        connection.run(connection.protocol.receive())
    assert not connection.transport.aborted


def test_pings_are_answered(connection: Connection) -> None:
    written = len(connection.transport.written)
    connection.protocol.data_received(PING * 3)
    assert len(connection.transport.written) - written == 3 * 102


def test_flood_of_pings_is_cut_off(connection: Connection) -> None:
    written = len(connection.transport.written)
    connection.protocol.data_received(PING * 100_000)
    assert connection.transport.aborted
    assert len(connection.transport.written) - written < 102 * PING_BURST + PIECE_BYTES


def test_flood_of_fragments_is_cut_off(connection: Connection) -> None:
    connection.protocol.data_received(frame(0x2, final=False) + frame(0x0, final=False) * 100_000)
    assert connection.transport.aborted
    assert len(connection.protocol.frames) <= MAX_FRAGMENTS


def test_messages_are_parsed_as_they_are_taken(connection: Connection) -> None:
    count = 20_000
    connection.protocol.data_received(MESSAGE * count)
    most = 0
    for _ in range(count):
        most = max(most, connection.protocol.queue.qsize())
        assert connection.run(connection.protocol.receive()) == {"type": "websocket.receive", "bytes": b"message"}
    assert most <= PIECE_BYTES / len(MESSAGE) + 1
    assert connection.transport.reading


def test_what_is_handed_over_is_little(connection: Connection) -> None:
    assert connection.transport.high == 0


@pytest.mark.skipif(not hasattr(socket, "TCP_NOTSENT_LOWAT"), reason="this platform has no TCP_NOTSENT_LOWAT")
def test_kernel_holds_little_of_what_is_unsent() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        socket.create_connection(listener.getsockname()),
        listener.accept()[0] as accepted,
    ):
        Connection(accepted)
        assert 0 < accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT) <= 64 << 10
