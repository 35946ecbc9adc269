"""The cost of many viewers for a server, the delay of their chunks, and the harm by clients that misbehave."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.serve.bad_clients import flooding, idling, pings, resting, stalled
from benchmarks.serve.measured_server import BenchServer
from benchmarks.serve.paced_viewers import Crowd, Pace
from hgs_core.codec.format.manifest import Manifest
from server.client.viewing import play
from server.protocol.messages import HEADER_BYTES, MIN_PAYLOAD

__all__ = ["bench_serve", "serve_text"]

WITNESSES = 5  # viewers among the others that play what they get, as the player does
AHEAD = 2.0  # seconds of the scene that the others ask for at once
STAY = 20.0  # seconds, at least, that they stay
STALLED, IDLE, FLOODERS, RESTING = 50, 5000, 4, 1000
PATIENCE = 90.0  # seconds in which those that do not read must be gone
LOOK_SECONDS = 0.2  # between two looks at whether they are
PING_SECONDS = 12.0  # longer than a connection may wait before it asks: the idle ones are closed meanwhile
REST_SECONDS = 20.0  # a server's keepalive pings come so often
FLOOD_SECONDS = 2.0  # a start for the viewers that seek


async def bench_serve(
    viewers: int,
    seconds: float,
    *,
    folder: Path | None = None,
    minutes: float = 1.0,
    processes: int = 1,
    bad_clients: bool = False,
) -> dict[str, Any]:
    """Let so many viewers watch a scene at its own rate, from servers in processes of their own.

    Args:
        viewers: how many, shared out evenly among the servers.
        seconds: how long, from when all are there.
        folder: of the scene; None: one that is made up.
        minutes: length of the made-up scene.
        processes: servers.
        bad_clients: afterwards, let clients misbehave as `benchmarks.serve.bad_clients` lists: three minutes.
    """
    servers = [BenchServer(folder, minutes) for _ in range(processes)]
    try:
        pace = _pace(servers[0].manifest)
        report: dict[str, Any] = {"viewers": viewers, "seconds": seconds, "processes": processes}
        report |= await _crowd(servers, viewers, seconds, pace)
        if bad_clients:
            report["bad_clients"] = await _bad_clients(servers[0])
        return report
    finally:
        for server in servers:
            server.close()


def _pace(manifest: Manifest) -> Pace:
    def framed(size: int) -> int:
        return size + size * HEADER_BYTES // MIN_PAYLOAD

    lasts = max(manifest.end - manifest.start, 1e-3)
    rate = framed(manifest.totals.bytes_dynamic) / lasts
    return Pace(framed(manifest.totals.bytes_static) + int(AHEAD * rate), rate, max(STAY, lasts))


async def _crowd(servers: Sequence[BenchServer], viewers: int, seconds: float, pace: Pace) -> dict[str, Any]:
    for server in servers:
        await play(server.url, 1.0)  # the first one's cost is not everyone's
    empty = [await server.costs() for server in servers]
    crowd = Crowd([server.url for server in servers], viewers, pace)
    try:
        await asyncio.sleep(crowd.joining + AHEAD)
        witnesses = [asyncio.create_task(play(servers[k % len(servers)].url, seconds)) for k in range(WITNESSES)]
        joined = await crowd.figures()
        before = [await server.costs() for server in servers]
        begun = time.monotonic()
        await asyncio.sleep(seconds)
        after = [await server.costs() for server in servers]
        passed = time.monotonic() - begun
        figures = await crowd.figures()
        seen = await asyncio.gather(*witnesses)
    finally:
        crowd.close()
    sent = figures.bytes + sum(one.bytes for one in seen)
    processor = [late.processor - early.processor for late, early in zip(after, before, strict=True)]
    more = sum(late.memory - early.memory for late, early in zip(after, empty, strict=True))
    starts = sorted(one.start for one in seen if one.start is not None)
    return {
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "visits": joined.visits + figures.visits,
        "lost": joined.lost + figures.lost,
        "bytes": sent,
        "mbit_per_viewer": 8e-6 * figures.bytes / passed / viewers,
        "server_seconds": sum(processor),
        "server_seconds_per_gb": sum(processor) / max(sent / 1e9, 1e-9),
        "busiest_core": max(processor) / passed,
        "viewers_cores": figures.processor / passed,
        "memory": sum(one.memory for one in after),
        "memory_per_viewer": more / viewers,
        "lateness": _quantiles(figures.lateness),
        "witnesses": {
            "count": len(seen),
            "playing": len(starts),
            "start_p50": starts[len(starts) // 2] if starts else None,
            "stalls": sum(one.stalls for one in seen),
        },
    }


async def _bad_clients(server: BenchServer) -> dict[str, Any]:
    report: dict[str, Any] = {"pings_alone": _quantiles(await pings(server.url, PING_SECONDS))}
    quiet = await server.costs()
    async with stalled(server.url, STALLED):
        begun, most, there = time.monotonic(), 0, STALLED
        while there > quiet.connections and time.monotonic() - begun < PATIENCE:
            await asyncio.sleep(LOOK_SECONDS)
            costs = await server.costs()
            there, most = costs.connections, max(most, costs.kernel)
        gone = time.monotonic() - begun
    report["stalled"] = {
        "count": STALLED,
        "still_there": max(there - quiet.connections, 0),
        "seconds": gone,
        "kernel_each": most / STALLED,
    }
    with resting(server.url, RESTING):
        await asyncio.sleep(REST_SECONDS)
        before = await server.costs()
        await asyncio.sleep(REST_SECONDS)
        used = (await server.costs()).processor - before.processor
        report["resting"] = {"count": RESTING, "server_seconds_each": used / REST_SECONDS / RESTING}
    before = await server.costs()
    with idling(server.port, IDLE):
        found = _quantiles(await pings(server.url, PING_SECONDS))
    used = (await server.costs()).processor - before.processor
    report["idle"] = {"count": IDLE, "pings": found, "server_seconds": used}
    with flooding(server.url, FLOODERS):
        await asyncio.sleep(FLOOD_SECONDS)
        with idling(server.port, IDLE):
            found = _quantiles(await pings(server.url, PING_SECONDS))
            report["idle_and_flooders"] = {"count": FLOODERS, "pings": found}
    return report


def _quantiles(values: Sequence[float]) -> dict[str, float | int | None]:
    ordered = sorted(values)
    last = len(ordered) - 1
    return {
        "count": len(ordered),
        "p50": ordered[len(ordered) // 2] if ordered else None,
        "p99": ordered[min(int(0.99 * len(ordered)), last)] if ordered else None,
        "max": ordered[-1] if ordered else None,
    }


def serve_text(report: Mapping[str, Any]) -> str:
    """Return the report as text."""
    witnesses = report["witnesses"]
    begin = (
        "none plays"
        if witnesses["start_p50"] is None
        else (f"{witnesses['playing']} play, after {witnesses['start_p50']:.2f} s (p50)")
    )
    rows = [
        f"{report['viewers']} viewers for {report['seconds']:.0f} s, {report['processes']} server(s): "
        f"{report['bytes'] / 1e6:.0f} MB, {report['mbit_per_viewer']:.2f} Mbit/s each, {report['lost']} lost",
        f"server: {report['server_seconds_per_gb']:.1f} s of processor time per GB, {report['busiest_core']:.2f} of a "
        f"core (the busiest; the viewers take {report['viewers_cores']:.2f}), {report['memory'] / 1e6:.0f} MB, "
        f"{report['memory_per_viewer'] / 1e3:.0f} kB a viewer",
        f"lateness: {_in_ms(report['lateness'])}; load of the machine {report['load']:.1f}",
        f"of {witnesses['count']} that play what they get {begin}; {witnesses['stalls']} stalls",
    ]
    if bad := report.get("bad_clients"):
        stuck = bad["stalled"]
        rows += [
            f"pings: {_in_ms(bad['pings_alone'])}",
            f"{stuck['count']} that do not read: {stuck['still_there']} of them there after {stuck['seconds']:.0f} s, "
            f"{stuck['kernel_each'] / 1e3:.0f} kB of the kernel's memory each",
            f"{bad['resting']['count']} viewers at rest: "
            f"{1e6 * bad['resting']['server_seconds_each']:.1f} us of processor time a second each",
            f"pings with {bad['idle']['count']} idle connections: {_in_ms(bad['idle']['pings'])}; "
            f"{bad['idle']['server_seconds']:.2f} s of processor time",
            f"and with {bad['idle_and_flooders']['count']} that seek all the time: "
            f"{_in_ms(bad['idle_and_flooders']['pings'])}",
        ]
    return "\n".join(rows)


def _in_ms(found: Mapping[str, Any]) -> str:
    if not found["count"]:
        return "none"
    return ", ".join(f"{name} {1e3 * found[name]:.1f} ms" for name in ("p50", "p99", "max"))
