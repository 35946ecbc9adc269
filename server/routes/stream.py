"""`WS /v1/scenes/{id}/stream`: carries one session's messages between its state machine and a socket."""

from __future__ import annotations

import asyncio
import logging
import time

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from starlette.concurrency import run_in_threadpool

from server.chunk_cache import ChunkCache
from server.problems import ProblemError, problem_response
from server.protocol import Error, ProtocolError, chunk_header, encode
from server.service import ServiceDep
from server.stream_session import ChunkPart, StreamSession

__all__ = ["router"]

router = APIRouter()
log = logging.getLogger("hgs.server")

HELLO_SECONDS = 10.0


@router.websocket("/v1/scenes/{scene_id}/stream")
async def stream(socket: WebSocket, scene_id: str, service: ServiceDep) -> None:
    """Stream one scene to one watcher until either side closes."""
    if not service.may_read(socket):
        detail = f"a page of {socket.headers['Origin']} may not read scenes on this server"
        await socket.send_denial_response(problem_response(socket, ProblemError(403, "origin-not-allowed", detail)))
        return
    await socket.accept()
    try:
        scene = await run_in_threadpool(service.scene, scene_id)
        await _converse(socket, StreamSession(scene), service.chunks)
    except WebSocketDisconnect:
        return
    except ProtocolError as error:
        await _refuse(socket, error.close_code, error.code, error.detail)
    except ProblemError as error:
        await _refuse(socket, 4004 if error.status == 404 else 1011, error.code, error.detail)
    except Exception:
        log.exception("the stream of scene %s broke", scene_id)
        await _refuse(socket, 1011, "internal", "a fault of the server; its log says more")


async def _converse(socket: WebSocket, session: StreamSession, chunks: ChunkCache) -> None:
    """Read and write at once; whichever side fails first ends both."""
    news = asyncio.Event()
    sides = {
        asyncio.create_task(_listen(socket, session, news)),
        asyncio.create_task(_speak(socket, session, chunks, news)),
    }
    try:
        done, _ = await asyncio.wait(sides, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for side in sides:
            side.cancel()
        await asyncio.gather(*sides, return_exceptions=True)
    for side in done:
        side.result()


async def _listen(socket: WebSocket, session: StreamSession, news: asyncio.Event) -> None:
    while True:
        try:
            message = await asyncio.wait_for(socket.receive(), None if session.greeted else HELLO_SECONDS)
        except TimeoutError:
            raise ProtocolError(4008, "hello-timeout", f"no hello within {HELLO_SECONDS:g} s") from None
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1005))
        data = message.get("bytes")
        if data is None:
            raise ProtocolError(1003, "not-binary", "control messages are binary, not text")
        session.receive(data, time.monotonic())
        news.set()


async def _speak(socket: WebSocket, session: StreamSession, chunks: ChunkCache, news: asyncio.Event) -> None:
    while True:
        item = session.take(time.monotonic())
        if item is None:
            await news.wait()
            news.clear()
            continue
        await socket.send_bytes(item if isinstance(item, bytes) else await _frame(item, chunks))
        await asyncio.sleep(0)  # sending does not wait while the socket has room, and others want to be served too


async def _frame(part: ChunkPart, chunks: ChunkCache) -> bytes:
    chunk = part.chunk
    data = await chunks.get(chunk.id.hex())
    if data is None or len(data) != chunk.size:
        raise LookupError(f"chunk {chunk.id.hex()}: missing, or not of the {chunk.size} bytes that the manifest says")
    header = chunk_header(chunk.id, part.offset, chunk.size)
    return b"".join((header, memoryview(data)[part.offset : part.offset + part.length]))


async def _refuse(socket: WebSocket, close_code: int, code: str, detail: str) -> None:
    """Say why, and close; the client may be gone already."""
    try:
        await socket.send_bytes(encode(Error(code, detail)))
        await socket.close(close_code)
    except (RuntimeError, WebSocketDisconnect):
        return
