"""`WS /v1/scenes/{id}/stream`: one session's messages between its state machine and the socket."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from typing import NoReturn

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from starlette.concurrency import run_in_threadpool

from server.http.problems import ProblemError, problem_response
from server.http.token_bucket import TokenBucket
from server.protocol.messages import Error, ProtocolError, chunk_header, encode
from server.protocol.stream_endings import Closing
from server.scenes.chunk_cache import ChunkCache
from server.scenes.live_scenes import LiveScenes
from server.scenes.scene_index import SceneIndex
from server.service import Service, ServiceDep
from server.stream.stream_session import ChunkPart, StreamSession

__all__ = ["router"]

router = APIRouter()
log = logging.getLogger("hgs.server")

HELLO_SECONDS = 10.0
MESSAGE_RATE = 100.0  # control messages per second; every sent chunk frame allows one more
MESSAGE_BURST = 200.0
MESSAGE_UNIT = 4096  # bytes; a longer message counts as several


@router.websocket("/v1/scenes/{scene_id}/stream")
async def stream(socket: WebSocket, scene_id: str, service: ServiceDep) -> None:
    """Stream one scene to one client until either side closes."""
    if not service.origins.may_read(socket):
        detail = f"a page of {socket.headers['Origin']} may not read scenes on this server"
        await socket.send_denial_response(problem_response(socket, ProblemError(403, "origin-not-allowed", detail)))
        return
    await socket.accept()
    try:
        # Joined before the lookup: a later deletion is always noticed.
        with service.watchers.join(scene_id) as gone:
            scene = await run_in_threadpool(service.catalogue.scene, scene_id)
            session = StreamSession(scene)
            try:
                await _converse(socket, session, service, gone)
            finally:
                service.metrics.stream_waits.inc(session.waits)
    except WebSocketDisconnect:
        return
    except ProtocolError as error:
        await _refuse(socket, error.closing.code, error.closing.error, error.detail)
    except ProblemError as error:
        closing = Closing.SCENE_NOT_FOUND if error.status == 404 else Closing.INTERNAL
        await _refuse(socket, closing.code, error.code, error.detail)
    except Exception:
        log.exception("the stream of scene %s broke", scene_id)
        await _refuse(socket, Closing.INTERNAL.code, Closing.INTERNAL.error, "a fault of the server; its log says more")


@router.get("/v1/scenes/{scene_id}/stream", include_in_schema=False, response_model=None)
def no_stream(scene_id: str) -> NoReturn:
    """Reject a stream request without its Upgrade header, which some proxy has dropped."""
    detail = (
        "this address is a WebSocket, but the request is not an upgrade: a proxy on the way does not pass on "
        "the header Upgrade (docs/deploy.md); the scene is also available over HTTP, from index.hgs beside this address"
    )
    raise ProblemError(426, "upgrade-needed", detail, headers={"Upgrade": "websocket"})


async def _converse(socket: WebSocket, session: StreamSession, service: Service, gone: asyncio.Event) -> None:
    """Read and write concurrently, until the scene is `gone`; the first failure ends both."""
    news = asyncio.Event()
    budget = TokenBucket(MESSAGE_RATE, MESSAGE_BURST)
    sides = {
        asyncio.create_task(_listen(socket, session, budget, news)),
        asyncio.create_task(_speak(socket, session, service.chunks, budget, news)),
        asyncio.create_task(_await_deletion(gone)),
        asyncio.create_task(_grow(session, session.scene, service.live, news)),
    }
    try:
        done, _ = await asyncio.wait(sides, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for side in sides:
            side.cancel()
        await asyncio.gather(*sides, return_exceptions=True)
    for side in done:
        side.result()


async def _listen(socket: WebSocket, session: StreamSession, budget: TokenBucket, news: asyncio.Event) -> None:
    while True:
        greeted = session.greeted
        try:
            async with asyncio.timeout(None if greeted else HELLO_SECONDS):
                message = await socket.receive()
        except TimeoutError:
            raise ProtocolError(Closing.HELLO_TIMEOUT, f"no hello within {HELLO_SECONDS:g} s") from None
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1005))
        data = message.get("bytes")
        if data is None:
            raise ProtocolError(Closing.NOT_BINARY, "control messages are binary, not text")
        session.receive(data, time.monotonic())
        news.set()
        # Nothing more is read from a client over its rate, so that others need not wait.
        if greeted and (pause := budget.spend(1 + len(data) // MESSAGE_UNIT, time.monotonic())) > 0:
            await asyncio.sleep(pause)


async def _speak(
    socket: WebSocket, session: StreamSession, chunks: ChunkCache, budget: TokenBucket, news: asyncio.Event
) -> None:
    while True:
        item = session.take(time.monotonic())
        if item is None:
            # wait_for loses a cancellation that arrives together with the event (before Python 3.12).
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(session.wait(time.monotonic())):
                    await news.wait()
            news.clear()
        elif isinstance(item, bytes):
            await socket.send_bytes(item)
        elif (data := item.data or await chunks.expect(item.chunk)) is None:
            session.miss(item)
        else:
            await socket.send_bytes(_frame(item, data))
            budget.earn(1)
        await asyncio.sleep(0)  # yields to other streams, since sending does not wait while the socket has room


async def _grow(session: StreamSession, scene: SceneIndex, live: LiveScenes, news: asyncio.Event) -> NoReturn:
    """Pass every later version of a growing scene to the session; only a fault ends this."""
    versions: asyncio.Queue[SceneIndex] = asyncio.Queue()
    with live.follow(scene, versions.put_nowait):
        while True:
            session.grow(await versions.get(), time.monotonic())
            news.set()


async def _await_deletion(gone: asyncio.Event) -> NoReturn:
    await gone.wait()
    raise ProtocolError(Closing.SCENE_NOT_FOUND, "the scene was deleted")


def _frame(part: ChunkPart, data: bytes) -> bytes:
    header = chunk_header(part.chunk.id, part.offset, part.chunk.size)
    return b"".join((header, memoryview(data)[part.offset : part.offset + part.length]))


async def _refuse(socket: WebSocket, close_code: int, code: str, detail: str) -> None:
    """Send an error and close; the client may be gone already."""
    try:
        await socket.send_bytes(encode(Error(code, detail)))
        await socket.close(close_code)
    except (RuntimeError, WebSocketDisconnect):
        return
