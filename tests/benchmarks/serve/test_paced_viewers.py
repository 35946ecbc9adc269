from __future__ import annotations

import asyncio

from benchmarks.serve.paced_viewers import Crowd, CrowdFigures, Pace
from server.bench.bench_scene import made_up_scene
from server.bench.one_scene_server import serving

SCENE = made_up_scene(10, static_bytes=120_000, slice_bytes=30_000)


async def figures_after(seconds: float, pace: Pace) -> CrowdFigures:
    async with serving(SCENE) as port:
        crowd = Crowd([f"ws://127.0.0.1:{port}/v1/scenes/bench/stream"], 2, pace)
        try:
            total = await crowd.figures()
            while total.visits < 2:
                total.add(await crowd.figures())
            await asyncio.sleep(seconds)
            total.add(await crowd.figures())
            return total
        finally:
            crowd.close()


def test_viewers_take_what_they_have_asked_for_and_no_more() -> None:
    found = asyncio.run(figures_after(1.2, Pace(140_000, 30_000, 0.0)))
    assert (found.visits, found.lost) == (2, 0)
    assert 2 * 120_000 < found.bytes < SCENE.size
    assert found.lateness
    assert min(found.lateness) >= 0


def test_viewers_begin_anew_when_they_have_all() -> None:
    found = asyncio.run(figures_after(1.0, Pace(2 * SCENE.size, 1_000, 0.0)))
    assert found.visits > 2


def test_viewers_that_have_all_stay_for_a_while() -> None:
    found = asyncio.run(figures_after(1.0, Pace(2 * SCENE.size, 1_000, 60.0)))
    assert (found.visits, found.lateness) == (2, [])
