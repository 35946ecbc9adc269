"""Copies of published scenes as folders."""

from __future__ import annotations

import json
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.codec.format.manifest_reading import parse_manifest
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, stored_sizes
from jobs.artifacts.artifact_store import ArtifactStore

__all__ = ["copy_scene"]


def copy_scene(store: ArtifactStore, scene_id: str, folder: Path, title: str) -> None:
    """Write a published scene to a folder under a title: its chunks, and the manifest last.

    Raises:
        KeyError: there is no such scene, or it is being deleted.
        InputError: the scene is damaged.
    """
    data = store.manifest(scene_id)
    if data is None:
        raise KeyError(scene_id)
    document, manifest = parse_manifest(data, f"manifest of scene {scene_id}")
    for chunk_id in stored_sizes(manifest):
        chunk = store.chunk(chunk_id)
        if chunk is None:
            raise KeyError(scene_id)
        write_bytes(folder / CHUNKS / chunk_id, chunk)
    write_bytes(folder / MANIFEST, json.dumps({**document, "title": title, "thumbnail": False}).encode())
