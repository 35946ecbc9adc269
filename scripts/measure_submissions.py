"""Measures how long viewers wait while captures that are slow to look at are submitted, many at a time.

.venv/bin/python -m scripts.measure_submissions [SECONDS]

A server of its own process, a published scene, and submissions of a capture of four videos, each a list of 54 times the
same file: none, then 44, then 400 at the same moment. Meanwhile four viewers ask for an address each, up to ten times a
second. Client and server share the machine.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import httpx
import numpy as np

from server.bench.bench_scene import made_up_scene

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


def publish(store: Path) -> None:
    """Put a made-up scene of noise into the folder of a store as `bench`."""
    scene = made_up_scene(4, static_bytes=120_000, slice_bytes=9_000)
    files = {f"chunks/{name}": content for name, content in scene.chunks.items()}
    for name, content in (files | {"scenes/bench/manifest.json": scene.document}).items():
        (store / name).parent.mkdir(parents=True, exist_ok=True)
        (store / name).write_bytes(content)


async def watch(client: httpx.AsyncClient, address: str, until: float, took: list[float]) -> None:
    """Ask for an address again and again, and note how long each answer takes."""
    while time.monotonic() < until:
        began = time.perf_counter()
        try:
            fit = (await client.get(address)).status_code == 200
        except httpx.TransportError:
            fit = False
        seconds = time.perf_counter() - began
        took.append(seconds if fit else PATIENCE)
        await asyncio.sleep(max(0.0, INTERVAL - seconds))


async def _submit_all(address: str, submissions: int) -> tuple[dict[int, int], float]:
    limits = httpx.Limits(max_connections=None)
    async with httpx.AsyncClient(base_url=address, timeout=PATIENCE, limits=limits) as client:

        async def submit(number: int) -> tuple[int, float]:
            began = time.perf_counter()
            answer = await client.post("/v1/jobs", json={"capture": "slow", "title": f"{submissions} {number}"})
            return answer.status_code, time.perf_counter() - began

        answers = await asyncio.gather(*(submit(number) for number in range(submissions)))
    return Counter(status for status, _ in answers), max((seconds for _, seconds in answers), default=0.0)


def submit_all(address: str, submissions: int) -> tuple[dict[int, int], float]:
    """Submit so many at once; return how many had each status, and the seconds of the slowest answer."""
    return asyncio.run(_submit_all(address, submissions))


async def measure(address: str, submissions: int, seconds: float) -> None:
    """Submit so many at once from another process, watch for so many seconds, and print the figures."""
    took: dict[str, list[float]] = {one: [] for one in ADDRESSES}
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as others:
        await asyncio.get_running_loop().run_in_executor(others, submit_all, address, 0)  # it has started
        sending = asyncio.get_running_loop().run_in_executor(others, submit_all, address, submissions)
        until = time.monotonic() + seconds
        async with httpx.AsyncClient(base_url=address, timeout=PATIENCE) as client:
            await asyncio.gather(*(watch(client, one, until, times) for one, times in took.items()))
        answers, slowest = await sending
    told = ", ".join(f"{count} x {status}" for status, count in sorted(answers.items()))
    print(f"{submissions} submissions: {told or 'none'}; the slowest answer {slowest:.2f} s")
    for one, times in took.items():
        half, most = np.percentile(times, (50, 99))
        print(f"  {one:28} {len(times):4} requests, p50 {1000 * half:6.0f} ms, p99 {1000 * most:6.0f} ms")


def main() -> None:
    """Measure all three."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        publish(root / "home" / "store")
        environment = {**os.environ, "HGS_HOME": str(root / "home"), "HGS_CAPTURES": str(root / "captures")}
        write_capture(root / "captures" / "slow")
        server = subprocess.Popen(
            [sys.executable, "-m", "server.cli", "serve", "--workers", "0", "--port", "0"],
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
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
