"""Viewers on lines of given rates: the start of playing, the duration of seeks, the number of pauses."""

from __future__ import annotations

import asyncio
import random
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Any

from server.bench.bench_scene import BenchScene
from server.bench.one_scene_server import serving
from server.bench.shaped_line import ShapedLine
from server.client.viewing import Viewer, Watched

__all__ = ["bench_stream", "stream_text", "watch"]

MBIT = 1e6
SEEKS = 20
DROPS = 5


@asynccontextmanager
async def _viewing(port: int, rate: Callable[[float], float]) -> AsyncIterator[Viewer]:
    async with ShapedLine(port, rate) as line:
        viewer = Viewer(f"ws://{line.address}/v1/scenes/bench/stream")
        running = asyncio.create_task(viewer.client.run())
        try:
            yield viewer
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def watch(port: int, rate: Callable[[float], float], seconds: float, *, drops: int = 0) -> Watched:
    """Watch for so many seconds on a line of `rate` bits per second, by the seconds since; it breaks `drops` times."""
    async with _viewing(port, rate) as viewer:
        begun = time.monotonic()
        broken = 0
        while (passed := time.monotonic() - begun) < seconds:
            if broken < drops and passed > (broken + 1) * seconds / (drops + 1):
                broken += 1
                viewer.client.drop()
            await viewer.frame()
        return viewer.watched()


async def _start(port: int, rate: float) -> Watched:
    async with _viewing(port, lambda _: rate) as viewer:
        while not viewer.playing:
            await viewer.frame()
        return viewer.watched()


async def _seeks(scene: BenchScene, port: int, rate: float) -> dict[str, Any]:
    """Seek to places that are not there yet, and to places that are."""
    dice = random.Random(1)
    start, end = scene.manifest.start, scene.manifest.end
    async with _viewing(port, lambda _: rate) as viewer:
        while not viewer.playing:
            await viewer.frame()
        missing: list[float] = []
        there: list[float] = []
        for _ in range(SEEKS):
            moment = dice.uniform(start, end)
            (there if viewer.can_show(moment) else missing).append(await viewer.sought(moment))
            there.append(await viewer.sought(moment))
        return {"missing": _quantiles(missing), "buffered": _quantiles(there), "twice": viewer.client.twice}


def _quantiles(values: Sequence[float]) -> dict[str, float | int]:
    ordered = sorted(values)
    return {"count": len(ordered), "p50": ordered[len(ordered) // 2], "max": ordered[-1]} if ordered else {"count": 0}


async def bench_stream(
    scene: BenchScene, seconds: float = 60.0
) -> tuple[dict[str, Any], list[Sequence[tuple[float, frozenset[str]]]]]:
    """Measure all that `hgs bench stream` tells of a scene; lines that are watched for long run side by side.

    Also returns what was shown on each of `lines`: seconds of the scene, and the chunks that were there.
    """
    async with serving(scene) as port:
        starts = [{"mbit": mbit, **_told(scene, await _start(port, mbit * MBIT), mbit * MBIT)} for mbit in (2, 50)]
        seeks = await _seeks(scene, port, 2 * MBIT)
        drops = await watch(port, lambda _: 2 * MBIT, min(seconds, 10.0), drops=DROPS)
        third = seconds / 3

        def falls(second: float) -> float:
            return MBIT if third <= second < 2 * third else 20 * MBIT

        lines: dict[str, Callable[[float], float]] = {
            "0.8 of its rate": lambda _: 0.8 * scene.rate,
            "0.5 of its rate": lambda _: 0.5 * scene.rate,
            "20, 1, 20 Mbit/s": falls,
        }
        watched = await asyncio.gather(*(watch(port, rate, seconds) for rate in lines.values()))
    report = {
        "scene": {"bytes": scene.size, "seconds": scene.manifest.end - scene.manifest.start, "mbit": scene.rate / MBIT},
        "starts": starts,
        "seeks": seeks,
        "drops": {"count": DROPS, "bytes": drops.bytes, "twice": drops.twice},
        "lines": [
            {"line": name, "seconds": seconds, **_told(scene, result, rate(0.0))}
            for (name, rate), result in zip(lines.items(), watched, strict=True)
        ],
    }
    return report, [result.shown for result in watched]


def _told(scene: BenchScene, watched: Watched, rate: float) -> dict[str, Any]:
    return {
        "start": watched.start,
        "start_of_line": 8 * watched.start_bytes / rate,  # seconds of the line alone for those bytes
        "start_share": watched.start_bytes / scene.size,
        "stalls": watched.stalls,
        "waited": watched.waited,
        "bytes": watched.bytes,
    }


def stream_text(report: Mapping[str, Any]) -> str:
    """Return the report as text."""
    scene, seeks, drops = report["scene"], report["seeks"], report["drops"]
    rows = [
        f"scene: {scene['bytes'] / 1e6:.2f} MB, {scene['seconds']:.1f} s, {scene['mbit']:.2f} Mbit/s of what moves",
        "",
        "line                 plays after   of the line   of the bytes   stalls   waited",
    ]
    for case in [{"line": f"{row['mbit']} Mbit/s", **row} for row in report["starts"]] + report["lines"]:
        start = "not" if case["start"] is None else f"{case['start']:.2f} s"
        rows.append(
            f"{case['line']:18s} {start:>13s} {case['start_of_line']:11.2f} s "
            f"{100 * case['start_share']:12.0f} % "
            f"{case['stalls']:8d} {case['waited']:6.1f} s"
        )
    for row in report["lines"]:
        if levels := sorted(row.get("psnr", ())):
            rows.append(
                f"{row['line']}: {levels[len(levels) // 2]:.1f} dB (median), "
                f"{levels[0]:.1f} dB (least) against the whole scene, the first time round"
            )
    for name, found in (("seeks to what is missing", seeks["missing"]), ("seeks to what is there", seeks["buffered"])):
        if found["count"]:
            rows.append(f"{name}, 2 Mbit/s: {found['count']}, p50 {found['p50']:.3f} s, max {found['max']:.3f} s")
    rows.append(
        f"bytes that came twice: {seeks['twice']} with seeks, {drops['twice']} of {drops['bytes']} with {DROPS} breaks"
    )
    return "\n".join(rows)
