"""Catalogue of published scenes: descriptions for the list, and cached indices for streams.

A complete scene never changes, so each description is read once; a scene that has grown, or was removed and
published again, has another version. A renamed scene costs one read of its title.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import OrderedDict
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

from starlette.concurrency import run_in_threadpool

from hgs_core.base.errors import InputError
from jobs.artifacts.artifact_store import SceneEntry
from server.http.encodable import encodable
from server.http.problems import ProblemError
from server.parts import Artifacts, Jobs
from server.scenes.scene_index import SceneIndex, read_scene

__all__ = ["SceneCatalogue", "unknown_scene"]


log = logging.getLogger("hgs.server")


@dataclass(frozen=True)
class _Known:
    """Cached description of a scene, or the reason why it has none."""

    version: str
    renamed: str
    description: dict[str, Any]
    fault: str = ""

    def describes(self, entry: SceneEntry) -> bool:
        """Return whether the scene is unchanged."""
        return (self.version, self.renamed) == (entry.version, entry.renamed)


class SceneCatalogue:
    """Scenes of a store. `scenes` is for an event loop; other methods block and are thread-safe."""

    def __init__(self, artifacts: Artifacts, jobs: Jobs, capacity: int = 128 << 20) -> None:
        """Describe the scenes of `artifacts`, with the titles of their jobs in `jobs`.

        `capacity` is the memory of the cached indices, in bytes, besides those of open streams.
        """
        self._artifacts = artifacts
        self._jobs = jobs
        self._known: dict[str, _Known] = {}
        self._unreadable: set[str] = set()  # unreadable scenes of the last scan; each is logged once
        self._indices: OrderedDict[str, tuple[str, SceneIndex]] = OrderedDict()  # versions and indices, by id
        self._indices_lock = threading.Lock()
        self._capacity = capacity
        self._one_look = asyncio.Lock()
        self._next_look: asyncio.Task[list[dict[str, Any]]] | None = None

    async def scenes(self) -> list[dict[str, Any]]:
        """Return the published scenes as JSON, newest first; unreadable ones are left out.

        Costs one listing of the store, and one read for each scene that is new or renamed. Callers that
        arrive during a scan of the store share the next one.
        """
        if self._next_look is None or self._next_look.done():
            self._next_look = asyncio.create_task(self._look())
        return await asyncio.shield(self._next_look)  # a caller that leaves must not cancel the scan of the others

    def chunk_ids(self, scene_id: str) -> frozenset[str]:
        """Return the ids of a scene's chunks, hex; none if the scene is missing or unreadable."""
        try:
            return self.scene(scene_id).chunk_ids
        except ProblemError:
            return frozenset()

    def describe(self, scene_id: str) -> dict[str, Any]:
        """Return one scene as JSON.

        Raises:
            ProblemError: as `scene`.
        """
        entry = self._entry(scene_id)
        known = self._known.get(scene_id)
        if known is None or not known.describes(entry):
            known = self._known[scene_id] = self._learn(entry, known, self._titles([scene_id]))
        if known.fault:
            raise ProblemError(500, "internal", known.fault)
        return known.description

    def scene(self, scene_id: str) -> SceneIndex:
        """Return the index of a scene, for streaming it.

        Raises:
            ProblemError: 404, no such scene; 500, its manifest is of another version or damaged.
        """
        entry = self._entry(scene_id)
        with self._indices_lock:
            version, index = self._indices.get(scene_id, ("", None))
        if index is None or version != entry.version:
            try:
                index = self._read(entry)
            except InputError as error:
                raise ProblemError(500, "internal", str(error)) from error
        with self._indices_lock:
            self._indices[scene_id] = entry.version, index
            self._indices.move_to_end(scene_id)
            size = sum(kept.memory for _, kept in self._indices.values())
            while size > self._capacity and len(self._indices) > 1:
                size -= self._indices.popitem(last=False)[1][1].memory
        return index

    async def _look(self) -> list[dict[str, Any]]:
        async with self._one_look:
            self._next_look = None  # later callers may expect newer scenes than this scan finds
            return await run_in_threadpool(self._refresh)

    def _refresh(self) -> list[dict[str, Any]]:
        entries = self._artifacts.list_scenes()
        before = self._known
        fresh = [entry for entry in entries if entry.id not in before or not before[entry.id].describes(entry)]
        titles = self._titles([entry.id for entry in fresh])
        read: dict[str, _Known] = {}
        unreadable: set[str] = set()
        for entry in fresh:
            try:
                read[entry.id] = self._learn(entry, before.get(entry.id), titles)
            except ProblemError:
                continue  # removed meanwhile
            except Exception as error:  # any exception of the store: other scenes remain readable
                unreadable.add(entry.id)
                if entry.id not in self._unreadable:
                    log.warning("scene %s cannot be read and is left out of the list: %s", entry.id, error)
        self._unreadable = unreadable
        self._known = {entry.id: known for entry in entries if (known := read.get(entry.id) or before.get(entry.id))}
        return [known.description for known in self._known.values() if not known.fault]

    def _learn(self, entry: SceneEntry, before: _Known | None, titles: dict[str, str]) -> _Known:
        """Read the changed parts of a scene: the title alone after a renaming, otherwise everything."""
        given = self._artifacts.title(entry.id) if entry.renamed else None
        if given and before is not None and before.version == entry.version:
            return replace(before, renamed=entry.renamed, description=before.description | {"title": encodable(given)})
        try:
            scene = self._artifacts.describe(entry)
        except InputError as error:
            log.warning("scene %s is left out of the list: %s", entry.id, error)
            return _Known(entry.version, entry.renamed, {}, str(error))
        if scene is None:
            raise unknown_scene(entry.id)
        description = {
            "id": entry.id,
            "title": given or titles.get(entry.id) or scene.title or entry.id,
            "created": entry.published.timestamp(),
            "start": scene.start,
            "end": scene.end,
            "bytes_total": scene.bytes_total,
            "splats_static": scene.splats_static,
            "splats_dynamic": scene.splats_dynamic,
            "live": scene.live,
        }
        return _Known(entry.version, entry.renamed, encodable(description))

    def _titles(self, scene_ids: Collection[str]) -> dict[str, str]:
        """Return the titles of scenes made by jobs, which have the jobs' ids."""
        return {job.id: job.title for job in self._jobs.many(scene_ids).values()} if scene_ids else {}

    def _entry(self, scene_id: str) -> SceneEntry:
        entry = self._artifacts.scene_entry(scene_id)
        if entry is None:
            raise unknown_scene(scene_id)
        return entry

    def _read(self, entry: SceneEntry) -> SceneIndex:
        manifest = self._artifacts.manifest(entry.id)
        if manifest is None:
            raise unknown_scene(entry.id)
        return read_scene(entry.id, manifest, self._artifacts.pages(entry.id, manifest))


def unknown_scene(scene_id: str) -> ProblemError:
    """Return the problem of an unpublished scene."""
    return ProblemError(404, "scene-not-found", f"scene {scene_id}: no such scene")
