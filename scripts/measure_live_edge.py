"""How far behind the newest segment of a scene that grows its viewers play.

    python -m scripts.measure_live_edge --segments 8 --viewers 20 --megabits 10

Encodes made-up splats, publishes their segments one by one, a little more slowly than they play, and serves them with
`hgs serve`. Viewers watch from the beginning over lines of that rate; told is how long after its publication a segment
is played.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hgs_core.base.atomic import write_bytes
from hgs_core.codec.encoder.encode import encode_scene
from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.scene_folder import MANIFEST
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from server.bench.shaped_line import ShapedLine
from server.client.viewing import Viewer

SECONDS = 2.0  # seconds of a segment
EVERY = 2.7  # seconds between two publications
FRAME_RATE = 30
STATIC, DYNAMIC = 20_000, 6_000  # splats in all, and of a segment


def main() -> None:
    """Measure, and print a line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--segments", type=int, default=8)
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--megabits", type=float, default=10.0, help="of each viewer's line, per second")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene"
        manifest = _encode(scene, options.segments)
        per_second = manifest.totals.bytes_dynamic / (manifest.end - manifest.start)
        command = [sys.executable, "-m", "server.cli", "serve", "--port", "0", "--workers", "0"]
        home = Path(folder) / "home"
        server = subprocess.Popen(
            command,
            env=os.environ | {"HGS_HOME": str(home)},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        try:
            assert server.stdout is not None
            port = int(server.stdout.readline().strip().rstrip("/").rpartition(":")[2])
            lags, stalls = asyncio.run(_measure(home, scene, manifest, port, options.viewers, options.megabits * 1e6))
        finally:
            server.terminate()
            server.wait()
    behind = np.array(lags)
    print(
        f"{options.viewers} viewers on {options.megabits:g} Mbit/s, {options.segments} segments of {SECONDS:g} s, "
        f"{8e-6 * per_second:.1f} Mbit/s: a segment plays {np.median(behind):.2f} s after its publication (median), "
        f"{behind.max():.2f} s (latest); {stalls} stalls"
    )


def _encode(out: Path, segments: int) -> Manifest:
    dice = np.random.default_rng(0)

    def still(count: int) -> StaticSplats[np.ndarray]:
        return StaticSplats(
            dice.normal(0, 1, (count, 3)).astype(np.float32),
            dice.normal(-4, 0.5, (count, 3)).astype(np.float32),
            dice.normal(0, 1, (count, 4)).astype(np.float32),
            dice.normal(0, 1, count).astype(np.float32),
            dice.uniform(0, 1, (count, 3)).astype(np.float32),
        )

    def moving() -> DynamicSplats[np.ndarray]:
        one = still(DYNAMIC)
        motion = (dice.normal(0, 1, (DYNAMIC, 4, 3)) * np.array([1, 0.3, 0.1, 0.03])[:, None]).astype(np.float32)
        turns = dice.normal(0, 1, (DYNAMIC, 2, 4)).astype(np.float32)
        centers = dice.uniform(0, 1, DYNAMIC).astype(np.float32)
        precisions = dice.normal(4, 1, DYNAMIC).astype(np.float32)
        return DynamicSplats(motion, turns, one.log_scales, one.opacity_logits, centers, precisions, one.rgb)

    camera = Camera("cam00", 640, 360, 500.0, 500.0, 320.0, 180.0, np.eye(4))
    times = np.arange(int(segments * SECONDS * FRAME_RATE)) / FRAME_RATE
    pieces = tuple(Segment(SECONDS * k, SECONDS * (k + 1), moving()) for k in range(segments))
    return encode_scene(HybridScene(still(STATIC), pieces), out, cameras=[camera], times=times, title="Growing")


async def _measure(
    home: Path, scene: Path, manifest: Manifest, port: int, viewers: int, rate: float
) -> tuple[Sequence[float], int]:
    """Return how long after their publication segments were played, and how often viewers waited for data."""
    store = open_store(Home.at(home))
    published: list[float] = []

    async def publish() -> None:
        for count in range(1, len(manifest.segments) + 1):
            begun = time.monotonic()
            text = json.dumps(first_segments(manifest, count).to_json(), separators=(",", ":"))
            write_bytes(scene / MANIFEST, text.encode())
            await asyncio.to_thread(store.put_scene, scene, "growing")
            published.append(time.monotonic())
            await asyncio.sleep(max(0.0, EVERY - (time.monotonic() - begun)))

    async def watch() -> tuple[list[float], int]:
        played: dict[int, float] = {}
        async with ShapedLine(port, lambda _: rate) as line:
            viewer = Viewer(f"ws://{line.address}/v1/scenes/growing/stream")
            running = asyncio.create_task(viewer.client.run())
            while len(played) < len(manifest.segments):
                await viewer.frame()
                if viewer.clock is not None and not viewer.clock.waiting:
                    played.setdefault(int(viewer.clock.time / SECONDS), time.monotonic())
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
        return [played[k] - published[k] for k in range(1, len(played))], viewer.watched().stalls

    publishing = asyncio.create_task(publish())
    while not published:
        await asyncio.sleep(0.01)
    watched = await asyncio.gather(*(watch() for _ in range(viewers)))
    await publishing
    return [lag for lags, _ in watched for lag in lags], sum(stalls for _, stalls in watched)


if __name__ == "__main__":
    main()
