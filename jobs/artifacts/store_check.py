"""The check of the store: every chunk named by a manifest is there, and its SHA-256 is its name."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.scene_folder import stored_sizes
from jobs.artifacts.artifact_store import ArtifactStore

__all__ = ["ChunkFault", "StoreCheck", "check_store", "chunks_of"]

_READERS = 8  # chunks read at once, each some megabytes at most


@dataclass(frozen=True)
class ChunkFault:
    """A chunk that the store cannot give, and the scenes that have a hole without it."""

    chunk: str
    problem: Literal["missing", "damaged"]
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class StoreCheck:
    """The extent of a check, and its findings."""

    scenes: int
    chunks: int
    bytes: int
    faults: tuple[ChunkFault, ...]
    unreadable: tuple[str, ...]  # scenes whose manifest is damaged: nobody knows what they name

    @property
    def sound(self) -> bool:
        """Whether nothing is wrong."""
        return not self.faults and not self.unreadable


def check_store(store: ArtifactStore, progress: Callable[[int, int], object] = lambda done, total: None) -> StoreCheck:
    """Read every chunk that a manifest names, and compare its SHA-256 with its name; the store is not changed.

    `progress` is called with how many chunks were read, of how many. A scene that is removed meanwhile does not count.
    """
    named: dict[str, list[str]] = {}
    unreadable, scenes = [], 0
    for entry in store.list_scenes():
        data = store.manifest(entry.id)
        if data is None:  # taken back since
            continue
        scenes += 1
        try:
            chunks = chunks_of(data)
        except InputError:
            unreadable.append(entry.id)
            continue
        for chunk in chunks:
            named.setdefault(chunk, []).append(entry.id)
    faults, total = [], 0
    with ThreadPoolExecutor(_READERS) as pool:
        found = pool.map(lambda chunk: _look(store, chunk), named)
        for done, (chunk, (size, problem)) in enumerate(zip(named, found, strict=True), 1):
            progress(done, len(named))
            total += size
            there = tuple(scene for scene in named[chunk] if problem and store.scene_entry(scene) is not None)
            if problem and there:
                faults.append(ChunkFault(chunk, problem, there))
    return StoreCheck(scenes, len(named), total, tuple(faults), tuple(unreadable))


def chunks_of(manifest: bytes) -> list[str]:
    """Return the ids of the chunks that a manifest names, of sound too, each once.

    Raises:
        InputError: it is malformed.
    """
    try:
        value = json.loads(manifest)
    except (ValueError, RecursionError) as error:
        raise InputError("manifest", f"is no JSON ({error})") from error
    return list(stored_sizes(read_manifest(value)))


def _look(store: ArtifactStore, chunk: str) -> tuple[int, Literal["missing", "damaged"] | None]:
    data = store.chunk(chunk)
    if data is None:
        return 0, "missing"
    return len(data), None if hashlib.sha256(data).hexdigest() == chunk else "damaged"
