from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import msgpack
import pytest

from hgs_core.codec.format.growth import apply_growth, continues
from hgs_core.codec.format.manifest import Manifest
from server import scene_opening
from server.bench_scene import made_up_scene
from server.live_scenes import LiveScenes
from server.one_scene_server import application
from server.protocol import Hello, Play, encode
from server.scene_index import SceneIndex, read_scene
from server.scene_opening import opening
from server.stream_session import ChunkPart, StreamSession

SCENE = made_up_scene(60, static_bytes=1_200, slice_bytes=90)
WHOLE = json.loads(SCENE.document)


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> SceneIndex:
    """A scene of a minute that counts as long: its manifest begins with 30 s."""
    monkeypatch.setattr(scene_opening, "LONG", 1000)
    return read_scene("bench", SCENE.document)


def hello(**fields: object) -> bytes:
    return encode(Hello(2, 1 << 26, follow=True, **fields))  # type: ignore[arg-type]


def messages(session: StreamSession, clock: float) -> list[dict[str, object]]:
    """Take all there is; return the control messages."""
    found = []
    while (item := session.take(clock)) is not None:
        if not isinstance(item, ChunkPart):
            found.append(msgpack.unpackb(item))
    return found


def test_beginning_is_a_version_of_which_the_whole_is_the_next(scene: SceneIndex) -> None:
    assert scene.opening is not None
    first = json.loads(scene.opening.manifest)
    assert (first["end"], len(first["segments"]), len(first["slices"])) == (30.0, 15, 60)
    Manifest.from_json(first, "the beginning")  # with the right sums
    assert continues(WHOLE, first)
    assert apply_growth(first, json.loads(scene.growth(scene.opening) or b"")) == WHOLE


def test_sound_of_the_beginning_is_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_opening, "LONG", 1000)
    pieces = [{"id": f"{k:064x}", "bytes": 9, "start": float(k), "end": k + 1.0} for k in range(60)]
    document = WHOLE | {"audio": {"codec": "opus", "sample_rate": 48000, "channels": 1, "pieces": pieces}}
    first = json.loads(opening(document, Manifest.from_json(document, "whole"), 5000) or b"")
    assert first["audio"]["pieces"] == pieces[:30]
    assert continues(document, first)


@pytest.mark.parametrize("change", [{"size": 999}, {"live": 3}, {"seconds": 4}])
def test_short_scenes_and_those_that_grow_have_none(change: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_opening, "LONG", 1000)
    document = json.loads(made_up_scene(change["seconds"]).document) if "seconds" in change else WHOLE
    document |= {name: value for name, value in change.items() if name == "live"}
    assert opening(document, Manifest.from_json(document, "scene"), change.get("size", 5000)) is None


def test_whole_manifest_comes_when_the_beginning_is_there(scene: SceneIndex) -> None:
    assert scene.opening is not None
    session = StreamSession(scene)
    session.receive(hello(), 0.0)
    told = messages(session, 0.0)
    assert (told[0]["type"], told[0]["manifest_id"]) == ("welcome", scene.opening.manifest_id)
    grow = next(k for k, message in enumerate(told) if message["type"] == "grow")
    assert told[grow]["manifest_id"] == scene.manifest_id
    assert {message["index"] for message in told[:grow] if message["type"] == "slice"} == set(range(60))
    assert {message["index"] for message in told if message["type"] == "slice"} == set(range(120))
    assert (told[-1]["type"], told[-1]["bytes"]) == ("end", scene.chunk_bytes)


def test_whole_manifest_comes_before_the_playhead_needs_it(scene: SceneIndex) -> None:
    session = StreamSession(scene)
    session.receive(encode(Hello(2, 0, follow=True)), 0.0)
    session.receive(encode(Play(0.0, 1.0)), 0.0)
    assert [message["type"] for message in messages(session, 9.0)] == ["welcome"]
    assert "grow" in [message["type"] for message in messages(session, 11.0)]


@pytest.mark.parametrize("why", ["does not follow", "starts later", "has it"])
def test_others_get_the_whole_manifest_at_once(scene: SceneIndex, why: str) -> None:
    session = StreamSession(scene)
    session.receive(
        {
            "does not follow": encode(Hello(2, 0)),
            "starts later": hello(time=20.0),
            "has it": hello(manifest_id=scene.manifest_id),
        }[why],
        0.0,
    )
    told = messages(session, 0.0)
    assert told[0]["manifest_id"] == scene.manifest_id
    assert "grow" not in [message["type"] for message in told]


def test_who_comes_back_with_the_beginning_is_not_sent_it_again(scene: SceneIndex) -> None:
    assert scene.opening is not None
    session = StreamSession(scene)
    session.receive(hello(manifest_id=scene.opening.manifest_id), 0.0)
    told = messages(session, 0.0)
    assert told[0]["manifest"] == b""
    assert "grow" in [message["type"] for message in told]


def test_scene_of_which_only_the_beginning_was_sent_is_not_followed_as_one_that_grows(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scene_opening, "LONG", 1000)
    followed: list[int | None] = []
    follow = LiveScenes.follow

    def noted(self: LiveScenes, scene: SceneIndex, *others: Any) -> Any:
        followed.append(scene.live)
        return follow(self, scene, *others)

    monkeypatch.setattr(LiveScenes, "follow", noted)
    waiting = [
        {"type": "websocket.disconnect", "code": 1000},
        {"type": "websocket.receive", "bytes": hello()},  # there before anything else runs
        {"type": "websocket.connect"},
    ]

    async def receive() -> Any:
        return waiting.pop()

    async def send(_: Any) -> None:
        pass

    path = "/v1/scenes/bench/stream"
    scope = {
        "type": "websocket", "path": path, "raw_path": path.encode(), "root_path": "", "scheme": "ws",
        "query_string": b"", "headers": [(b"host", b"localhost")], "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 80), "subprotocols": [],
    }  # fmt: skip
    asyncio.run(application(SCENE, tmp_path)(scope, receive, send))  # type: ignore[arg-type]
    assert followed in ([], [None])
