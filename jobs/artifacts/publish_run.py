"""Putting the scene of a run into the artifact store."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.codec.format.growth import replaces
from hgs_core.codec.format.scene_folder import MANIFEST
from jobs.artifacts.artifact_store import ArtifactStore

__all__ = ["encoded_scene", "publish_run"]


def publish_run(store: ArtifactStore, run: Path, scene_id: str = "", progress: ProgressCallback = silent) -> str:
    """Publish a run's scene under `scene_id` and return the id; publishing the same scene again changes nothing.

    A scene that has grown since is published in place of what it was.
    Without an id it is the name of the run's folder; where another scene has that name, a part of the scene's hash is
    added.

    Raises:
        InputError: the run has no encoded scene, the scene is damaged, or the id is malformed or taken. No scene is
            published then.
    """
    folder, manifest = encoded_scene(run)
    if scene_id:
        if _is_taken(store, scene_id, manifest):
            raise InputError(f"--id {scene_id}", "another scene has this id", "choose another id")
    else:
        slug = re.sub(r"[^a-z0-9]+", "-", run.resolve().name.lower()).strip("-")[:48].strip("-") or "scene"
        taken = _is_taken(store, slug, manifest)
        scene_id = f"{slug}-{hashlib.sha256(manifest).hexdigest()[:8]}" if taken else slug
    store.put_scene(folder, scene_id, progress)
    return scene_id


def _is_taken(store: ArtifactStore, scene_id: str, manifest: bytes) -> bool:
    there = store.manifest(scene_id)
    return there is not None and there != manifest and not replaces(manifest, there)


def encoded_scene(run: Path) -> tuple[Path, bytes]:
    """Return the folder of a run's encoded scene and its manifest's bytes.

    Raises:
        InputError: the run has no encoded scene.
    """
    folder = run / "scene"
    if not (folder / MANIFEST).is_file():
        raise InputError(run, "has no encoded scene", "give a run that hgs train has finished")
    return folder, (folder / MANIFEST).read_bytes()
