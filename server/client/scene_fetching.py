"""Watching a scene without a stream: its chunks are fetched over HTTP in the order in which the playhead needs them."""

from __future__ import annotations

import asyncio
import hashlib
import json
import random
import time
from collections.abc import Callable

from server.client.received_scene import ReceivedScene
from server.client.scene_files import AwayError, SceneFiles
from server.scenes.scene_index import Chunk, SceneIndex, read_whole
from server.stream.playhead import Playhead
from server.stream.send_order import SendOrder

__all__ = ["SceneFetching"]

PARALLEL = 4  # downloads
MOST_REFUSALS = 3  # answers with other bytes, for one chunk
POLL = 2.0  # seconds between two looks at a scene that grows
FIRST_RETRY = 0.5  # seconds; doubled with each attempt
LAST_RETRY = 8.0


class SceneFetching:
    """Fetches all of a scene for a client that plays it, and follows it while it grows."""

    def __init__(
        self,
        scene: ReceivedScene,
        files: SceneFiles,
        playhead: Callable[[], tuple[float | None, float]],
        *,
        splats: int | None = None,
        audio: bool = False,
    ) -> None:
        """Bring `files` to `scene`; `playhead` returns seconds on its clock, None for its start, and its rate."""
        self._scene, self._files, self._playhead = scene, files, playhead
        self._splats, self._audio = splats, audio
        self._refusals: dict[str, int] = {}
        self._failures = 0

    async def run(self) -> None:
        """Fetch; return once a complete scene is here.

        Raises:
            StreamRefusedError: the scene is refused.
        """
        index = await self._manifest()
        while True:
            await self._fetch_all(index)
            if index.live is None:
                return
            index = await self._later(index)

    async def _manifest(self) -> SceneIndex:
        while True:
            try:
                document = await self._files.manifest()
            except AwayError:
                await self._wait()
                continue
            if document is not None:
                self._failures = 0
                return self._become(document)

    async def _later(self, index: SceneIndex) -> SceneIndex:
        """Return the next version of a scene that grows."""
        while True:
            await asyncio.sleep(POLL)
            try:
                document = await self._files.manifest()
            except AwayError:
                await self._wait()
                continue
            if document is not None and document != json.loads(index.manifest):
                return self._become(document)

    def _become(self, document: dict[str, object]) -> SceneIndex:
        text = json.dumps(document).encode()
        self._scene.become(document)
        self._scene.manifests += 1
        self._scene.wire += len(text)
        self._scene.arrived()
        return read_whole(self._scene.url, text)

    async def _fetch_all(self, index: SceneIndex) -> None:
        """Fetch the missing chunks, a few at a time."""
        order = self._order(index)
        running: dict[asyncio.Task[bool], Chunk] = {}
        try:
            while True:
                while len(running) < PARALLEL and (chunk := self._next(order, index)) is not None:
                    order.settle(chunk)
                    running[asyncio.create_task(self._fetch(chunk))] = chunk
                if not running:
                    break
                done, _ = await asyncio.wait(running, return_when=asyncio.FIRST_COMPLETED)
                came = [task.result() for task in done]
                for task in done:
                    del running[task]
                if not all(came):
                    await self._wait()
                    order = self._order(index)
                    for chunk in running.values():
                        order.settle(chunk)
        finally:
            for task in running:
                task.cancel()
        self._scene.complete = index.live is None
        self._scene.arrived()

    def _order(self, index: SceneIndex) -> SendOrder:
        there = (*self._scene.have, *self._scene.missing)
        order = SendOrder(index, [bytes.fromhex(name) for name in there])
        order.limit(self._splats)
        order.hear(self._audio)
        return order

    def _next(self, order: SendOrder, index: SceneIndex) -> Chunk | None:
        place, rate = self._playhead()
        playhead = Playhead(index.start, index.end, index.start, grows=index.live is not None)
        playhead.set(index.start if place is None else place, 0.0, rate)
        return order.next(playhead.at(0.0), rate, self._scene.line.rate(time.monotonic()) or None)

    async def _fetch(self, chunk: Chunk) -> bool:
        """Fetch a chunk; return whether it is settled: it is here, or cannot be had."""
        name = chunk.id.hex()
        try:
            data = await self._files.chunk(name)
        except AwayError:
            return False
        if data is None or len(data) != chunk.size or hashlib.sha256(data).hexdigest() != name:
            self._refusals[name] = self._refusals.get(name, 0) + (MOST_REFUSALS if data is None else 1)
            if self._refusals[name] < MOST_REFUSALS:
                return False
            self._scene.missing.add(name)
        else:
            self._failures = 0
            self._scene.payload += len(data)
            self._scene.wire += len(data)
            self._scene.line.count(len(data), time.monotonic())
            self._scene.take(name, data)
        self._scene.arrived()
        return True

    async def _wait(self) -> None:
        await asyncio.sleep(random.random() * min(LAST_RETRY, FIRST_RETRY * 2**self._failures))
        self._failures = min(self._failures + 1, 8)
