"""What many viewers cost the server: its processor time, when they begin to play, and how often they wait."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import resource
from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import Any

from server.stream_bench import made_up_scene, serving
from server.viewing import Watched, play

__all__ = ["bench_serve", "serve_text"]


def bench_serve(viewers: int, seconds: float) -> dict[str, Any]:
    """Let so many viewers watch a made-up scene at once, from a server in a process of its own."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    server = spawn.Process(target=_serve, args=(theirs,), daemon=True)
    server.start()
    try:
        port = ours.recv()
        watched = asyncio.run(_watch(port, viewers, seconds))
        ours.send("stop")
        processor = ours.recv()
    finally:
        ours.close()
        server.join(30)
    sent = sum(one.bytes for one in watched)
    starts = sorted(one.start for one in watched if one.start is not None)
    return {
        "viewers": viewers,
        "seconds": seconds,
        "cores": os.cpu_count(),
        "bytes": sent,
        "server_seconds": processor,
        "server_seconds_per_gb": processor / max(sent / 1e9, 1e-9),
        "playing": len(starts),
        "start_p50": starts[len(starts) // 2] if starts else None,
        "start_max": starts[-1] if starts else None,
        "stalls": sum(one.stalls for one in watched),
    }


def serve_text(report: Mapping[str, Any]) -> str:
    """Return the report as text."""
    begin = "none plays" if report["start_p50"] is None else (
        f"{report['playing']} play, after {report['start_p50']:.2f} s (p50), {report['start_max']:.2f} s (max)"
    )  # fmt: skip
    return (
        f"{report['viewers']} viewers for {report['seconds']:.0f} s: {report['bytes'] / 1e6:.0f} MB, server "
        f"{report['server_seconds']:.2f} s of processor time, {report['server_seconds_per_gb']:.1f} s per GB; "
        f"{begin}; {report['stalls']} stalls"
    )


async def _watch(port: int, viewers: int, seconds: float) -> list[Watched]:
    url = f"ws://127.0.0.1:{port}/v1/scenes/bench/stream"
    return list(await asyncio.gather(*(play(url, seconds) for _ in range(viewers))))


def _serve(pipe: Connection) -> None:
    asyncio.run(_until_told(pipe))


async def _until_told(pipe: Connection) -> None:
    async with serving(made_up_scene()) as port:
        before = _processor_seconds()
        pipe.send(port)
        await asyncio.to_thread(pipe.recv)
        pipe.send(_processor_seconds() - before)


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime
