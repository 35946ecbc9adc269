"""Removes the chunks that no published scene names any more.

A publisher stores the missing chunks, then the manifest, under a lock that excludes collectors
(`jobs.artifacts.publishing_lock`). A collector works under the same lock, so it never meets chunks whose manifest is
still to come.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from hgs_core.base.errors import InputError
from jobs.artifacts.artifact_store import ArtifactStore

__all__ = ["Collection", "collect_chunks"]

PATIENCE = 60.0  # seconds to wait for a pause between publications
YOUNGEST = 3600.0  # seconds: what is younger stays, should a publisher not see our lock
_BATCH = 1000  # chunks removed by one request
_READERS = 16  # manifests read at once

_CHUNK_NAME = re.compile(rb"[0-9a-f]{64}")


@dataclass(frozen=True)
class Collection:
    """Chunks that no scene names: removed, or in a dry run only found."""

    chunks: int = 0
    bytes: int = 0
    scenes: int = 0  # manifests read


def collect_chunks(store: ArtifactStore, *, delete: bool, youngest: float = YOUNGEST) -> Collection:
    """Find, and if `delete` is given remove, the chunks older than `youngest` seconds that no manifest names.

    Removing can be interrupted at any moment: what is left is found the next time.

    Raises:
        InputError: a manifest cannot be read, so that nobody knows what it names; nothing is removed then. Or scenes
            are being published without a pause.
    """
    with store.lock.collecting(PATIENCE) if delete else contextlib.nullcontext():
        before = datetime.now(UTC) - timedelta(seconds=youngest)
        found = {chunk.id: chunk.size for chunk in store.list_chunks() if chunk.stored < before}
        scenes = [entry.id for entry in store.list_scenes()]
        with ThreadPoolExecutor(_READERS) as pool:
            for named in pool.map(lambda scene_id: _named(store, scene_id), scenes):
                for chunk_id in named:
                    found.pop(chunk_id, None)
        if delete:
            doomed = list(found)
            for start in range(0, len(doomed), _BATCH):
                store.remove_chunks(doomed[start : start + _BATCH])
    return Collection(len(found), sum(found.values()), len(scenes))


def _named(store: ArtifactStore, scene_id: str) -> Iterator[str]:
    """Return every chunk that a manifest may name: all that looks like one, so that no version's reader is needed."""
    manifest = store.manifest(scene_id)
    if manifest is None:  # taken back since
        return iter(())
    try:
        json.loads(manifest)
    except (ValueError, RecursionError) as error:
        cure = f"delete the scene, or put its manifest right; until then no chunk is removed ({error})"
        raise InputError(f"scene {scene_id}", "its manifest is damaged", cure) from error
    return (name.decode() for name in _CHUNK_NAME.findall(manifest))
