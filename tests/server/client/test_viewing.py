from __future__ import annotations

import asyncio

import pytest

from server.bench.bench_scene import made_up_scene
from server.bench.one_scene_server import serving
from server.client.playback import Buffer, Clock
from server.client.stream_client import StreamClient
from server.client.viewing import Viewer, play

SCENE = made_up_scene(1, static_bytes=12_000, slice_bytes=3_000)


def test_scene_is_played_once() -> None:
    async def scenario() -> None:
        async with serving(SCENE) as port:
            watched = await asyncio.wait_for(play(f"ws://127.0.0.1:{port}/v1/scenes/bench/stream"), 60)
        assert watched.start is not None
        assert 0 < watched.start_bytes <= SCENE.size + 5000
        assert (watched.bytes, watched.twice) == (sum(map(len, SCENE.chunks.values())), 0)
        assert [int(2 * moment) for moment, _ in watched.shown][:2] == [0, 1]
        assert set(watched.shown[-1][1]) == set(SCENE.chunks)
        assert "shown" not in watched.to_json()

    asyncio.run(scenario())


def test_playhead_waits_where_it_has_been_sent_while_what_comes_next_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    manifest = made_up_scene(4, static_bytes=12_000, slice_bytes=3_000).manifest
    monkeypatch.setattr(StreamClient, "manifest", manifest)

    async def scenario() -> None:
        viewer = Viewer("ws://127.0.0.1:1/none")
        viewer.clock = Clock(Buffer(manifest), 0.0)
        lacking = {entry.id for entry in manifest.slices[3].chunks}  # the last one before 2 s; no other needs them
        viewer.client.have.update((entry.id, b"") for entry in manifest.chunks if entry.id not in lacking)
        seeking = asyncio.create_task(viewer.sought(1.9999))
        await asyncio.sleep(0.1)
        assert not seeking.done()
        assert viewer.clock.time == 1.9999
        viewer.client.have.update(dict.fromkeys(lacking, b""))
        await asyncio.wait_for(seeking, 60)

    asyncio.run(scenario())


def test_seek_ends_when_the_moment_can_be_shown() -> None:
    async def scenario() -> None:
        async with serving(SCENE) as port:
            viewer = Viewer(f"ws://127.0.0.1:{port}/v1/scenes/bench/stream")
            running = asyncio.create_task(viewer.client.run())
            while not viewer.playing:
                await viewer.frame()
            assert await asyncio.wait_for(viewer.sought(0.75), 60) >= 0
            assert viewer.can_show(0.75)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    asyncio.run(scenario())
