"""Viewers of a soak: they play published scenes by the stream, again and again, and keep count of their waits."""

from __future__ import annotations

import asyncio
from typing import Any

from benchmarks.soak.client_calls import ClientCalls
from benchmarks.soak.request_history import Act, Event
from server.client.stream_client import StreamRefusedError
from server.client.viewing import play

__all__ = ["watch_scenes"]

SHORTEST, LONGEST = 3.0, 8.0  # seconds to watch


def watch_scenes(calls: ClientCalls, viewers: int) -> None:
    """Let so many viewers watch until the soak is over."""

    async def watch() -> None:
        await asyncio.gather(*(_viewer(calls, number) for number in range(viewers)))

    asyncio.run(watch())


async def _viewer(calls: ClientCalls, number: int) -> None:
    board = calls.board
    while not calls.over:
        if not board.scenes:
            await asyncio.sleep(0.5)
            continue
        scene, seconds = calls.dice.choice(board.scenes[-10:]), calls.dice.uniform(SHORTEST, LONGEST)
        began = board.history.now
        status, facts = await _watched(calls, scene, seconds)
        event = Event(Act.WATCH, scene, status, facts, {"seconds": seconds}, began, board.history.now)
        board.history.note(event)
        await asyncio.sleep(0.2 * (number + 1))


async def _watched(calls: ClientCalls, scene: str, seconds: float) -> tuple[int, dict[str, Any]]:
    url = f"ws://{calls.board.address}/v1/scenes/{scene}/stream"
    try:
        watched = await play(url, seconds, calls.board.key)
    except StreamRefusedError as error:
        return 404, {"code": str(error)}
    facts = {"start": watched.start, "stalls": watched.stalls, "waited": watched.waited}
    return 200, facts | {"over_http": watched.over_http, "bytes": watched.bytes}
