"""Measures how long viewers wait while captures that are slow to look at are submitted, many at a time.

.venv/bin/python -m scripts.measure_submissions [SECONDS]

A server of its own process, a published scene, and submissions of a capture of four videos, each a list of 54 times the
same file: none, then 44, then 400 at the same moment. Meanwhile a viewer asks for each of four addresses, ten times a
second. Client and server share the machine.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import httpx
import numpy as np

from hgs_core.base.progress import silent
from jobs.artifacts import open_store
from jobs.home import Home
from server.bench_scene import made_up_scene

CAMERAS, LINES = 4, 54
ADDRESSES = ("/healthz", "/readyz", "/v1/scenes/bench/index.hgs", "/view/bench")
INTERVAL = 0.1  # seconds between two requests for one address
PATIENCE = 60.0  # seconds that a request may take
ROOT = Path(__file__).resolve().parent.parent


def write_capture(folder: Path) -> None:
    """Write videos that are lists of one file, and poses for them."""
    (folder / "sub").mkdir(parents=True)
    shutil.copy(ROOT / "samples" / "studio" / "cam00.mp4", folder / "sub" / "real.mp4")
    for number in range(CAMERAS):
        text = "ffconcat version 1.0\n" + "file 'sub/real.mp4'\n" * LINES
        (folder / f"cam{number:02}.mp4").write_text(text)
    poses = np.load(ROOT / "samples" / "studio" / "poses_bounds.npy", allow_pickle=False)
    np.save(folder / "poses_bounds.npy", poses[:CAMERAS])


def publish(home: Home, folder: Path) -> None:
    """Publish a made-up scene as `bench`."""
    scene = made_up_scene(4, static_bytes=120_000, slice_bytes=9_000)
    (folder / "chunks").mkdir(parents=True)
    (folder / "manifest.json").write_bytes(scene.document)
    for name, content in scene.chunks.items():
        (folder / "chunks" / name).write_bytes(content)
    open_store(home).put_scene(folder, "bench", silent)


async def watch(client: httpx.AsyncClient, address: str, until: float, took: list[float]) -> None:
    """Ask for an address again and again, and note how long each answer takes."""
    waiting: set[asyncio.Task[None]] = set()

    async def ask() -> None:
        began = time.perf_counter()
        answer = await client.get(address)
        took.append(time.perf_counter() - began if answer.status_code == 200 else PATIENCE)

    while time.monotonic() < until:
        waiting.add(asyncio.create_task(ask()))
        await asyncio.sleep(INTERVAL)
    for done in await asyncio.gather(*waiting, return_exceptions=True):
        if isinstance(done, BaseException):
            took.append(PATIENCE)


async def measure(address: str, submissions: int, seconds: float) -> None:
    """Submit so many at once, watch for so many seconds, and print what was seen."""
    limits = httpx.Limits(max_connections=None)
    async with httpx.AsyncClient(base_url=address, timeout=PATIENCE, limits=limits) as client:
        answers: Counter[int] = Counter()
        slowest: list[float] = [0.0]

        async def submit(number: int) -> None:
            began = time.perf_counter()
            answer = await client.post("/v1/jobs", json={"capture": "slow", "title": f"{submissions} {number}"})
            answers[answer.status_code] += 1
            slowest.append(time.perf_counter() - began)

        until = time.monotonic() + seconds
        took: dict[str, list[float]] = {one: [] for one in ADDRESSES}
        sending = [asyncio.create_task(submit(number)) for number in range(submissions)]
        await asyncio.gather(*(watch(client, one, until, times) for one, times in took.items()), *sending)
    told = ", ".join(f"{count} x {status}" for status, count in sorted(answers.items()))
    print(f"{submissions} submissions: {told or 'none'}; the slowest answer {max(slowest):.2f} s")
    for one, times in took.items():
        half, most = np.percentile(times, (50, 99))
        print(f"  {one:28} {len(times):4} requests, p50 {1000 * half:6.0f} ms, p99 {1000 * most:6.0f} ms")


def main() -> None:
    """Measure all three."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        publish(Home.at(root / "home"), root / "scene")
        environment = {**os.environ, "HGS_HOME": str(root / "home"), "HGS_CAPTURES": str(root / "captures")}
        write_capture(root / "captures" / "slow")
        server = subprocess.Popen(
            [sys.executable, "-m", "server.cli", "serve", "--workers", "0", "--port", "0"],
            env=environment, stdout=subprocess.PIPE, text=True, cwd=ROOT,
        )  # fmt: skip
        try:
            assert server.stdout is not None
            address = server.stdout.readline().strip().rstrip("/")
            for submissions in (0, 44, 400):
                asyncio.run(measure(address, submissions, seconds))
            print(f"the server {'lives' if server.poll() is None else 'has ended'}")
        finally:
            server.kill()
            server.communicate()


if __name__ == "__main__":
    main()
