"""Growing scenes: detects new versions and notifies the streams that follow them."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterator

from starlette.concurrency import run_in_threadpool

from server.http.problems import ProblemError
from server.scenes.scene_index import SceneIndex

__all__ = ["LiveScenes"]

POLL_SECONDS = 1.0  # interval between reads of a followed scene's manifest

log = logging.getLogger("hgs.server")

Grown = Callable[[SceneIndex], None]


class LiveScenes:
    """Streams of this process that follow growing scenes, by scene; for one event loop."""

    def __init__(self, read: Callable[[str], SceneIndex], deleted: Callable[[str], None]) -> None:
        """Read scenes with `read`, in a thread; call `deleted` for a scene that is gone."""
        self._read, self._deleted = read, deleted
        self._following: dict[str, set[Grown]] = {}
        self._looking: dict[str, asyncio.Task[None]] = {}

    @contextlib.contextmanager
    def follow(self, scene: SceneIndex, grown: Grown) -> Iterator[None]:
        """Call `grown` with every later version of a scene inside the `with` block; complete scenes have none."""
        if scene.live is None:
            yield
            return
        name = scene.scene_id
        self._following.setdefault(name, set()).add(grown)
        if name not in self._looking or self._looking[name].done():
            self._looking[name] = asyncio.create_task(self._look(scene))
        try:
            yield
        finally:
            following = self._following[name]
            following.discard(grown)
            if not following:
                del self._following[name]
                self._looking.pop(name).cancel()

    async def _look(self, scene: SceneIndex) -> None:
        """Poll until the scene is complete or nothing follows it."""
        faulty = False
        while True:
            await asyncio.sleep(POLL_SECONDS)
            try:
                found = await run_in_threadpool(self._read, scene.scene_id)
                faulty = False
            except ProblemError as error:
                if error.status == 404:
                    self._deleted(scene.scene_id)
                    return
                continue
            except Exception as error:  # a fault of the store, which may be temporary
                if not faulty:
                    log.warning("growing scene %s cannot be read: %s", scene.scene_id, error)
                faulty = True
                continue
            # Streams may have started with a version newer than this one.
            for grown in tuple(self._following[scene.scene_id]):
                grown(found)
            if found.live is None:
                return
