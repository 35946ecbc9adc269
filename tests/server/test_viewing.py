from __future__ import annotations

import asyncio

from server.bench_scene import made_up_scene
from server.one_scene_server import serving
from server.viewing import Viewer, play

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
