"""Scenes that grow while clients watch, on a real server."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

import httpx
import pytest

from hgs_core.codec.format.growth import first_segments
from server.bench.bench_scene import made_up_scene
from server.client.stream_client import StreamClient, StreamRefusedError
from server.http.problems import ProblemError
from server.scenes import live_scenes
from server.scenes.live_scenes import LiveScenes
from server.scenes.scene_index import SceneIndex, read_scene
from tests.server.conftest import Server, running_server

SCENE = made_up_scene(6, static_bytes=90_000, slice_bytes=9000)
VERSIONS = [json.dumps(first_segments(SCENE.manifest, count).to_json()).encode() for count in (1, 2, 3)]


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_scenes, "POLL_SECONDS", 0.01)


def publish(server: Server, version: int) -> None:
    for data in SCENE.chunks.values():
        server.artifacts.add_chunk(data)
    server.artifacts.manifests["growing"] = VERSIONS[version]


def watched(server: Server, talk: Callable[[StreamClient], Awaitable[None]]) -> StreamClient:
    """Let `talk` look at a client of the scene while it receives."""

    async def scenario() -> StreamClient:
        async with running_server(server.app) as (_, address):
            client = StreamClient(f"ws://{address}/v1/scenes/growing/stream")
            running = asyncio.create_task(client.run())
            try:
                await asyncio.wait_for(asyncio.gather(talk(client), asyncio.shield(running)), 60)
            finally:
                running.cancel()
            return client

    return asyncio.run(scenario())


async def until(client: StreamClient, segments: int) -> None:
    """Wait until all of so many segments is there."""
    while not (client.complete and client.manifest is not None and len(client.manifest.segments) == segments):
        await asyncio.sleep(0.005)


def test_client_follows_a_scene_to_its_end(server: Server) -> None:
    publish(server, 0)

    async def talk(client: StreamClient) -> None:
        for version in range(3):
            publish(server, version)
            await until(client, version + 1)
        await client.close()

    client = watched(server, talk)
    assert client.manifest is not None
    assert client.manifest.to_json() == SCENE.manifest.to_json()
    assert client.have == SCENE.chunks
    assert (client.twice, client.manifests, client.connections) == (0, 1, 1)


def test_client_that_was_away_while_the_scene_grew_gets_nothing_twice(server: Server) -> None:
    publish(server, 0)

    async def talk(client: StreamClient) -> None:
        await until(client, 1)
        publish(server, 2)
        client.drop()
        await until(client, 3)
        await client.close()

    client = watched(server, talk)
    assert client.manifest is not None
    assert client.manifest.to_json() == SCENE.manifest.to_json()
    assert client.twice == 0


def test_stream_ends_when_another_process_deletes_the_scene(server: Server) -> None:
    publish(server, 0)

    async def talk(client: StreamClient) -> None:
        await until(client, 1)
        del server.artifacts.manifests["growing"]

    with pytest.raises(StreamRefusedError, match="scene-not-found"):
        watched(server, talk)


def test_manifest_of_a_growing_scene_is_polled_by_its_tag(server: Server) -> None:
    publish(server, 0)
    path = "/v1/scenes/growing/manifest"
    first = server.get(path)
    assert server.get(path, If_None_Match=first.headers["ETag"]).status_code == 304
    assert server.get("/v1/scenes/growing").json()["live"] is True
    publish(server, 2)
    later: httpx.Response = server.get(path, If_None_Match=first.headers["ETag"])
    assert (later.status_code, later.content) == (200, VERSIONS[2])
    assert server.get("/v1/scenes/growing").json()["live"] is False


def test_nobody_looks_at_scenes_that_nobody_follows_or_that_are_complete() -> None:
    looks: list[str] = []
    told: list[Any] = []
    first, last = (read_scene("growing", version) for version in (VERSIONS[0], VERSIONS[2]))
    outcomes: list[SceneIndex | Exception] = [OSError("away"), ProblemError(500, "internal", "damaged"), first, last]

    def read(scene_id: str) -> SceneIndex:
        looks.append(scene_id)
        outcome = outcomes[len(looks) - 1]
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    async def scenario() -> None:
        live = LiveScenes(read, told.append)
        with live.follow(last, told.append):
            pass
        with live.follow(first, told.append), live.follow(first, lambda scene: told.append(scene)):
            while len(told) < 4:
                await asyncio.sleep(0.005)
            await asyncio.sleep(0.05)
        assert live._following == {} == live._looking

    asyncio.run(scenario())
    assert looks == ["growing"] * 4
    assert told == [first, first, last, last]
