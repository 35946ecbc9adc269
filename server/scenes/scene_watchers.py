"""Streams by scene, so that they end when their scene is deleted."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Iterator

__all__ = ["SceneWatchers"]


class SceneWatchers:
    """Streams of this process by scene; for one event loop."""

    def __init__(self) -> None:
        """Start without streams."""
        self._watching: dict[str, set[asyncio.Event]] = {}

    @contextlib.contextmanager
    def join(self, scene_id: str) -> Iterator[asyncio.Event]:
        """Watch a scene inside the `with` block; the event is set when the scene is deleted."""
        gone = asyncio.Event()
        self._watching.setdefault(scene_id, set()).add(gone)
        try:
            yield gone
        finally:
            watching = self._watching.get(scene_id)
            if watching is not None:
                watching.discard(gone)
                if not watching:
                    del self._watching[scene_id]

    def tell(self, scene_id: str) -> None:
        """Notify all streams of a scene that it is gone."""
        for gone in self._watching.get(scene_id, ()):
            gone.set()
