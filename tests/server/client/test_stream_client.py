from __future__ import annotations

import asyncio
import dataclasses
import hashlib
import json
from collections.abc import Awaitable, Callable

import pytest

from hgs_core.codec.format.audio import AudioEntry, AudioPiece
from server.bench.bench_scene import BenchScene, made_up_scene
from server.bench.one_scene_server import serving
from server.client.stream_client import StreamClient, StreamRefusedError
from server.protocol.messages import Play

SCENE = made_up_scene(2, static_bytes=1_800_000, slice_bytes=300_000)  # a chunk is several frames


def with_client(
    talk: Callable[[StreamClient], Awaitable[None]],
    scene: str = "bench",
    *,
    of: BenchScene = SCENE,
    audio: bool = False,
) -> StreamClient:
    """Let `talk` look at a client while it receives `of`."""

    async def scenario() -> StreamClient:
        async with serving(of) as port:
            client = StreamClient(f"ws://127.0.0.1:{port}/v1/scenes/{scene}/stream", audio=audio)
            running = asyncio.create_task(client.run())
            try:
                await asyncio.wait_for(asyncio.gather(talk(client), asyncio.shield(running)), 60)
            finally:
                running.cancel()
            return client

    return asyncio.run(scenario())


async def until_complete(client: StreamClient) -> None:
    while not client.complete:
        await asyncio.sleep(0.01)
    await client.close()


def test_whole_scene_comes_once() -> None:
    client = with_client(until_complete)
    assert client.have == SCENE.chunks
    assert client.manifest is not None
    assert client.manifest.to_json() == SCENE.manifest.to_json()
    assert (client.payload, client.twice) == (sum(map(len, SCENE.chunks.values())), 0)
    assert client.wire < SCENE.size + 10_000


def test_broken_connections_cost_no_byte_twice() -> None:
    async def break_often(client: StreamClient) -> None:
        for share in (0.1, 0.3, 0.5, 0.7):
            while client.payload < share * SCENE.size:
                await asyncio.sleep(0)
            client.drop()
        await until_complete(client)

    client = with_client(break_often)
    assert client.have == SCENE.chunks
    assert client.connections > 1
    assert (client.twice, client.manifests) == (0, 1)


def sounding() -> BenchScene:
    """A scene of two seconds with sound."""
    silent = made_up_scene(2, static_bytes=120_000, slice_bytes=6000)
    sounds = {hashlib.sha256(data).hexdigest(): data for data in (bytes([k]) * 9000 for k in range(2))}
    pieces = tuple(AudioPiece(name, 9000, float(k), k + 1.0) for k, name in enumerate(sounds))
    manifest = dataclasses.replace(silent.manifest, audio=AudioEntry("opus", 48_000, 2, pieces))
    return BenchScene(manifest, json.dumps(manifest.to_json()).encode(), {**silent.chunks, **sounds})


def test_sound_comes_if_asked_for_and_is_kept_when_the_connection_breaks() -> None:
    scene = sounding()
    assert scene.manifest.audio is not None
    sounds = set(scene.manifest.audio.sizes)

    async def break_late(client: StreamClient) -> None:
        while not sounds & set(client.have):
            await asyncio.sleep(0)
        client.drop()
        await until_complete(client)

    client = with_client(break_late, of=scene, audio=True)
    assert (client.have, client.twice) == (scene.chunks, 0)
    assert sounds.isdisjoint(with_client(until_complete, of=scene).have)


def test_playhead_is_told_to_the_next_connection() -> None:
    async def play_then_break(client: StreamClient) -> None:
        while not client.have:
            await asyncio.sleep(0)
        await client.send(Play(1.75, 1.0))
        client.drop()
        have = set(client.have)
        while len(client.have) < len(have) + 8:
            await asyncio.sleep(0)
        last = SCENE.manifest.slices[-1]
        assert last.chunks[0].id in client.have
        await until_complete(client)

    with_client(play_then_break)


def test_scene_that_is_not_there_is_refused() -> None:
    async def nothing(_: StreamClient) -> None:
        return

    with pytest.raises(StreamRefusedError, match=r"scene-not-found|4004"):
        with_client(nothing, "nowhere")


def test_chunks_are_what_their_names_say() -> None:
    assert all(hashlib.sha256(data).hexdigest() == name for name, data in with_client(until_complete).have.items())
