from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from benchmarks.soak import scene_viewers
from benchmarks.soak.client_calls import Board, ClientCalls
from benchmarks.soak.request_history import Act, Event
from benchmarks.soak.scene_viewers import watch_scenes
from server.client.stream_client import StreamRefusedError
from server.client.viewing import Watched


def test_viewers_watch_scenes_until_the_end_and_note_their_waits(
    board: Board, noted: Callable[[], list[Event]], monkeypatch: pytest.MonkeyPatch
) -> None:
    board.scenes.append("a")

    async def play(url: str, seconds: float, key: str) -> Watched:
        if len(noted()) >= 2:
            board.stop.set()
            raise StreamRefusedError("4004: no such scene")
        assert (url, key) == ("ws://127.0.0.1:1/v1/scenes/a/stream", "hgs_key")
        return Watched(0.5, 10, 1, 2.0, 100, 0, ())

    monkeypatch.setattr(scene_viewers, "play", play)
    watch_scenes(ClientCalls("viewers", board, 1), 1)
    watched: dict[str, Any] = {"start": 0.5, "stalls": 1, "waited": 2.0, "over_http": False, "bytes": 100}
    assert [(event.act, event.status) for event in noted()] == [(Act.WATCH, 200)] * 2 + [(Act.WATCH, 404)]
    assert noted()[0].answer == watched
