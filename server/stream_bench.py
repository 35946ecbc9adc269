"""What a viewer gets on lines of given rates: when playing begins, how long seeks take, how often it waits."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
import random
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

import numpy as np
from fastapi import FastAPI

from hgs_core.codec.format.folder import CHUNKS, MANIFEST, load_manifest
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.scene.camera import Camera
from jobs.artifacts import SceneEntry
from jobs.home import Home
from server.app import create_app
from server.protocol import PROTOCOL_VERSION
from server.service import Artifacts, Jobs
from server.serving import HttpServer, bind
from server.shaped_line import ShapedLine
from server.viewing import Viewer, Watched

__all__ = ["BenchScene", "application", "bench_stream", "made_up_scene", "scene_of", "serving", "stream_text", "watch"]

MBIT = 1e6
SEEKS = 20
DROPS = 5


@dataclass(frozen=True)
class BenchScene:
    """A scene to be served."""

    manifest: Manifest
    document: bytes  # of the manifest
    chunks: Mapping[str, bytes]

    @property
    def size(self) -> int:
        """Bytes of all chunks and of the manifest."""
        return len(self.document) + sum(map(len, self.chunks.values()))

    @property
    def rate(self) -> float:
        """Bits per second of what moves."""
        return 8 * self.manifest.totals.bytes_dynamic / max(self.manifest.end - self.manifest.start, 1e-3)


def scene_of(folder: Path) -> BenchScene:
    """Read a scene folder.

    Raises:
        InputError: it has no manifest of a scene.
        OSError: a chunk cannot be read.
    """
    manifest = load_manifest(folder)
    chunks = {entry.id: (folder / CHUNKS / entry.id).read_bytes() for entry in manifest.chunks}
    return BenchScene(manifest, (folder / MANIFEST).read_bytes(), chunks)


def made_up_scene(seconds: int = 60, *, static_bytes: int = 900_000, slice_bytes: int = 60_000) -> BenchScene:
    """Return a scene of random bytes in segments of 2 s and slices of half a second, each of two chunks."""
    dice, chunks = random.Random(0), {}
    box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))

    def entry(size: int) -> ChunkEntry:
        data = dice.randbytes(size)
        name = hashlib.sha256(data).hexdigest()
        chunks[name] = data
        return ChunkEntry(name, size, max(1, size // 10), box)

    slices: list[SliceEntry] = []
    for place in range(2 * seconds):
        segment, start = place // 4, place / 2
        needs = tuple(piece.chunks[0].id for piece in slices[-2:] if piece.segment == segment)
        slices.append(
            SliceEntry(segment, start, start + 0.5, (entry(slice_bytes * 2 // 3), entry(slice_bytes // 3)), needs)
        )
    manifest = Manifest(
        title="Made up",
        start=0.0,
        end=float(seconds),
        frame_rate=30.0,
        background=(0.0, 0.0, 0.0),
        up=(0.0, -1.0, 0.0),
        center=(0.0, 0.0, 0.0),
        extent=4.0,
        cameras=(Camera("cam00", 640, 360, 500.0, 500.0, 320.0, 180.0, np.eye(4)),),
        segments=tuple(SegmentEntry(2.0 * k, 2.0 * k + 2) for k in range((seconds + 1) // 2)),
        static=tuple(entry(static_bytes // 12) for _ in range(12)),
        slices=tuple(slices),
        thumbnail=False,
        training={},
    )
    return BenchScene(manifest, json.dumps(manifest.to_json(), separators=(",", ":")).encode(), chunks)


class _OneScene:
    """A store that holds one scene, `bench`."""

    def __init__(self, scene: BenchScene) -> None:
        self._scene = scene

    def scene_entry(self, scene_id: str) -> SceneEntry | None:
        return SceneEntry("bench", datetime.now(UTC), "1") if scene_id == "bench" else None

    def manifest(self, scene_id: str) -> bytes | None:
        return self._scene.document if scene_id == "bench" else None

    def title(self, scene_id: str) -> str | None:
        return None

    def thumbnail(self, scene_id: str) -> bytes | None:
        return None

    def chunk(self, chunk_id: str) -> bytes | None:
        return self._scene.chunks.get(chunk_id)


class _NoJobs:
    """A queue that has never had a job."""

    def many(self, job_ids: Collection[str]) -> dict[str, Any]:
        return {}


def application(scene: BenchScene, home: Path) -> FastAPI:
    """Return the server's application with a scene, `bench`, and a queue that has never had a job."""
    store, nothing = cast(Artifacts, _OneScene(scene)), cast(Jobs, _NoJobs())
    app = create_app(Home(home, "", ""), job_client=nothing, artifacts=store)
    app.router.lifespan_context = _no_lifespan
    return app


@asynccontextmanager
async def serving(scene: BenchScene) -> AsyncIterator[int]:
    """Serve a scene as `bench` in this process, with the pages; gives the port."""
    with tempfile.TemporaryDirectory() as home, contextlib.closing(bind("127.0.0.1", 0)) as listener:
        ready = asyncio.Event()
        server = HttpServer(application(scene, Path(home)), on_ready=ready.set)
        running = asyncio.create_task(server.serve(sockets=[listener]))
        try:
            await ready.wait()
            yield listener.getsockname()[1]
        finally:
            server.should_exit = True
            await running


@asynccontextmanager
async def _no_lifespan(_: Any) -> AsyncIterator[None]:
    yield


@asynccontextmanager
async def _viewing(port: int, rate: Callable[[float], float], protocol: int) -> AsyncIterator[Viewer]:
    async with ShapedLine(port, rate) as line:
        viewer = Viewer(f"ws://{line.address}/v1/scenes/bench/stream", protocol)
        running = asyncio.create_task(viewer.client.run())
        try:
            yield viewer
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def watch(
    port: int, rate: Callable[[float], float], seconds: float, *, protocol: int = PROTOCOL_VERSION, drops: int = 0
) -> Watched:
    """Watch for so many seconds on a line of `rate` bits per second, by the seconds since; it breaks `drops` times."""
    async with _viewing(port, rate, protocol) as viewer:
        begun = time.monotonic()
        broken = 0
        while (passed := time.monotonic() - begun) < seconds:
            if broken < drops and passed > (broken + 1) * seconds / (drops + 1):
                broken += 1
                viewer.client.drop()
            await viewer.frame()
        return viewer.watched()


async def _start(port: int, rate: float, protocol: int) -> Watched:
    async with _viewing(port, lambda _: rate, protocol) as viewer:
        while not viewer.playing:
            await viewer.frame()
        return viewer.watched()


async def _seeks(scene: BenchScene, port: int, rate: float) -> dict[str, Any]:
    """Seek to places that are not there yet, and to places that are."""
    dice = random.Random(1)
    start, end = scene.manifest.start, scene.manifest.end
    async with _viewing(port, lambda _: rate, PROTOCOL_VERSION) as viewer:
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
        starts = [
            {"mbit": mbit, "protocol": protocol, **_told(scene, await _start(port, mbit * MBIT, protocol))}
            for mbit in (2, 50)
            for protocol in (1, 2)
        ]
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
        cases = [(name, protocol) for name in lines for protocol in (1, 2)]
        watched = await asyncio.gather(
            *(watch(port, lines[name], seconds, protocol=version) for name, version in cases)
        )
    report = {
        "scene": {"bytes": scene.size, "seconds": scene.manifest.end - scene.manifest.start, "mbit": scene.rate / MBIT},
        "starts": starts,
        "seeks": seeks,
        "drops": {"count": DROPS, "bytes": drops.bytes, "twice": drops.twice},
        "lines": [
            {"line": name, "protocol": protocol, "seconds": seconds, **_told(scene, result)}
            for (name, protocol), result in zip(cases, watched, strict=True)
        ],
    }
    return report, [result.shown for result in watched]


def _told(scene: BenchScene, watched: Watched) -> dict[str, Any]:
    return {
        "start": watched.start,
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
        "line               protocol   plays after   of the bytes   stalls   waited",
    ]
    for case in [{"line": f"{row['mbit']} Mbit/s", **row} for row in report["starts"]] + report["lines"]:
        start = "not" if case["start"] is None else f"{case['start']:.2f} s"
        rows.append(
            f"{case['line']:18s} {case['protocol']:8d} {start:>13s} {100 * case['start_share']:12.0f} % "
            f"{case['stalls']:8d} {case['waited']:6.1f} s"
        )
    for row in report["lines"]:
        if levels := sorted(row.get("psnr", ())):
            rows.append(
                f"{row['line']}, protocol {row['protocol']}: {levels[len(levels) // 2]:.1f} dB (median), "
                f"{levels[0]:.1f} dB (least) against the whole scene, the first time round"
            )
    for name, found in (("seeks to what is missing", seeks["missing"]), ("seeks to what is there", seeks["buffered"])):
        if found["count"]:
            rows.append(f"{name}, 2 Mbit/s: {found['count']}, p50 {found['p50']:.3f} s, max {found['max']:.3f} s")
    rows.append(
        f"bytes that came twice: {seeks['twice']} with seeks, {drops['twice']} of {drops['bytes']} with {DROPS} breaks"
    )
    return "\n".join(rows)
