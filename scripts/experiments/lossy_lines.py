"""What viewers get on lines with loss and delay: over a WebSocket, with two congestion controls, and over QUIC.

    python -m scripts.experiments.lossy_lines [RUN] --loss 0 1 2 --trip 40 100 --mbit 2 10 --json FILE

Needs Linux, root's rights and iproute2; for the transports `quic` (one stream) and `quic-apart` (a stream for each
chunk) aioquic, too. Server and viewer are in network namespaces of their own, and packets between them pass the line of
scripts/experiments/packet_line.py.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import multiprocessing
import os
import random
import resource
import socket
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractAsyncContextManager
from dataclasses import asdict
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from scripts.experiments.packet_line import CLIENT, SERVER, Line, carry, enter_namespace, receive_device
from server.bench.bench_scene import BenchScene, made_up_scene, scene_of
from server.bench.one_scene_server import serving
from server.client.viewing import Viewer
from server.listener.http_server import bind
from server.scenes.scene_index import read_scene

TRANSPORTS = ("cubic", "bbr", "quic", "quic-apart")
STARTS, SEEKS = 5, 10
PATIENCE = 60.0  # seconds for a start


def _scene(source: Path | float) -> BenchScene:
    """Read the scene of a folder, or make one up of so many Mbit per second of what moves."""
    return scene_of(source) if isinstance(source, Path) else made_up_scene(60, slice_bytes=int(source * 1e6 / 16))


def _serve(pipe: Connection, end: socket.socket, transport: str, source: Path | float) -> None:
    enter_namespace(end, SERVER)
    scene = _scene(source)

    def service() -> AbstractAsyncContextManager[int]:
        if not transport.startswith("quic"):
            listener = bind(SERVER, 0)
            listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_CONGESTION, transport.encode())
            return serving(scene, listener)
        from scripts.experiments.quic_stream import serving_quic

        return serving_quic(read_scene("bench", scene.document), scene.chunks, SERVER, transport == "quic-apart")

    async def run() -> None:
        async with service() as port:
            pipe.send(port)
            while await asyncio.to_thread(pipe.recv):
                used = resource.getrusage(resource.RUSAGE_SELF)
                pipe.send(used.ru_utime + used.ru_stime)

    asyncio.run(run())


def _watch(pipe: Connection, end: socket.socket, transport: str, port: int, seconds: float, seed: int) -> None:
    enter_namespace(end, CLIENT)
    pipe.send(asyncio.run(_figures(transport, f"ws://{SERVER}:{port}/v1/scenes/bench/stream", seconds, seed)))


async def _figures(transport: str, url: str, seconds: float, seed: int) -> dict[str, Any]:
    starts = [(await _view(transport, url, 0.0, 0, seed)).pop("start") for _ in range(STARTS - 1)]
    found = await _view(transport, url, seconds, SEEKS, seed)
    return found | {"starts": [*starts, found.pop("start")]}


async def _view(transport: str, url: str, seconds: float, seeks: int, seed: int) -> dict[str, Any]:
    viewer = Viewer(url)
    if transport.startswith("quic"):
        from scripts.experiments.quic_stream import QuicStreamClient

        viewer.client = QuicStreamClient(url)
    running = asyncio.create_task(viewer.client.run())
    dice, begun = random.Random(seed), time.monotonic()
    try:
        while not viewer.playing and time.monotonic() - begun < PATIENCE:
            await viewer.frame()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            await viewer.frame()
        seen, sought = viewer.watched(), []
        while len(sought) < seeks and viewer.clock is not None and not viewer.client.complete:
            manifest = viewer.clock.buffer.manifest
            moment = dice.uniform(manifest.start, manifest.end)
            if not viewer.can_show(moment):
                sought.append(await viewer.sought(moment))
        return {
            "start": seen.start,
            "stalls": seen.stalls,
            "waited": seen.waited,
            "seeks": sorted(sought),
            "bytes": viewer.client.wire,
        }
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


def measure(line: Line, transport: str, source: Path | float, seconds: float, seed: int) -> dict[str, Any]:
    """Return what a viewer got on one line over one transport."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    ends = [socket.socketpair() for _ in range(2)]
    server = spawn.Process(target=_serve, args=(theirs, ends[0][1], transport, source))
    server.start()
    devices = [receive_device(ends[0][0])]
    port = ours.recv()
    result, told = spawn.Pipe(duplex=False)
    viewer = spawn.Process(target=_watch, args=(told, ends[1][1], transport, port, seconds, seed))
    viewer.start()
    told.close()
    devices.append(receive_device(ends[1][0]))
    ours.send("costs")
    before = ours.recv()
    lost, dropped = carry(line, (devices[0], devices[1]), seed, result.fileno())
    found: dict[str, Any] = result.recv()
    ours.send("costs")
    used = ours.recv() - before
    for process in (viewer, server):
        process.kill()
        process.join()
    for device in devices:
        os.close(device)
    return asdict(line) | found | {"transport": transport, "lost": lost, "dropped": dropped, "server_seconds": used}


def main() -> None:
    """Measure all lines, the transports of each side by side, and print a row for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, nargs="?", help="a scene folder; default: a made-up scene")
    parser.add_argument("--rate", type=float, default=0.96, help="Mbit/s of what moves in the made-up scene")
    parser.add_argument("--loss", type=float, nargs="+", default=[0.0, 1.0, 2.0], help="per cent of the packets")
    parser.add_argument("--trip", type=float, nargs="+", default=[40.0, 100.0], help="milliseconds, there and back")
    parser.add_argument("--mbit", type=float, nargs="+", default=[2.0, 10.0], help="of the line, per second")
    parser.add_argument("--transports", nargs="+", default=TRANSPORTS, choices=TRANSPORTS)
    parser.add_argument("--seconds", type=float, default=20.0, help="to watch each")
    parser.add_argument("--seed", type=int, default=1, help="of the losses")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    lines = [Line(m, t / 1000, p / 100) for m in options.mbit for t in options.trip for p in options.loss]
    results = []
    spawn = multiprocessing.get_context("spawn")
    print("Mbit/s  trip  loss  transport   start p50  max     stalls waited  seeks p50  max    s per GB  lost")
    with ProcessPoolExecutor(len(options.transports), mp_context=spawn) as pool:
        for line in lines:
            measured = [
                pool.submit(measure, line, transport, options.run or options.rate, options.seconds, options.seed)
                for transport in options.transports
            ]
            for one in (each.result() for each in measured):
                results.append(one)
                starts, seeks = sorted(s or PATIENCE for s in one["starts"]), one["seeks"] or [0.0]
                print(
                    f"{line.mbit:6g} {1e3 * line.trip:5.0f} {100 * line.loss:5g}  {one['transport']:11s}"
                    f"{starts[len(starts) // 2]:9.2f} {starts[-1]:6.2f} {one['stalls']:7d} {one['waited']:6.1f}"
                    f"{seeks[len(seeks) // 2]:9.2f} {seeks[-1]:7.2f} {1e9 * one['server_seconds'] / one['bytes']:8.1f}"
                    f"{one['lost']:8d}",
                    flush=True,
                )
    if options.json is not None:
        options.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    sys.exit(main())
