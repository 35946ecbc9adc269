"""How an encoded scene comes into the store: its chunks first, the manifest last."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import obstore
from obstore.exceptions import AlreadyExistsError
from obstore.store import ObjectStore

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.codec.format.growth import replaces
from hgs_core.codec.format.manifest_reading import parse_manifest
from hgs_core.codec.format.paging import paged
from hgs_core.codec.format.scene_folder import (
    ENCODE_AGAIN,
    MANIFEST,
    THUMBNAIL,
    checked_chunks,
    load_manifest,
    stored_sizes,
)
from jobs.artifacts.scene_description import DESCRIPTION, SceneDescription

__all__ = ["PAGES", "Publication"]

PAGES = "pages.bin"
"""Beside the manifest of a long scene: the same in pages."""


class Publication:
    """One scene on its way from a folder into the store."""

    def __init__(self, store: ObjectStore, folder: Path, scene_id: str, progress: ProgressCallback) -> None:
        """Read the manifest.

        Raises:
            InputError: there is none, or it is malformed.
        """
        self._store = store
        self._folder = folder
        self._scene = f"scenes/{scene_id}"
        self._progress = progress
        self._manifest = load_manifest(folder)

    def waits(self) -> None:
        """Report that others keep the scene from being published at the moment."""
        self._progress(Progress("publish", 0, len(stored_sizes(self._manifest)) + 1))

    def put(self, there: bytes | None, require_lock: Callable[[], object]) -> None:
        """Put the missing files; nothing unless the manifest that is `there` is an earlier version of this one.

        `require_lock` is called before the manifest is put, and raises if nobody may publish any more.

        Raises:
            InputError: a file is missing or damaged.
        """
        text = _read(self._folder / MANIFEST)
        grows = there is not None and replaces(text, there)
        known = _chunk_names(there) if there is not None and grows else frozenset()
        total = len(stored_sizes(self._manifest).keys() - known) + 1
        for done, (chunk, data) in enumerate(checked_chunks(self._folder, self._manifest, known)):
            self._progress(Progress("publish", done, total))
            self._create(f"chunks/{chunk.id}", data)
        self._progress(Progress("publish", total - 1, total))
        if self._manifest.thumbnail:
            self._create(f"{self._scene}/{THUMBNAIL}", _read(self._folder / THUMBNAIL))
        require_lock()
        document = json.loads(text)
        if (ready := paged(self._manifest, document)).pages:
            obstore.put(self._store, f"{self._scene}/{PAGES}", ready.packed(text))
        if grows:
            tag = obstore.put(self._store, f"{self._scene}/{MANIFEST}", text)["e_tag"]
        else:
            tag = self._create(f"{self._scene}/{MANIFEST}", text)
        if tag is not None:
            described = SceneDescription.of(document, len(text)).packed(tag)
            obstore.put(self._store, f"{self._scene}/{DESCRIPTION}", described)
        self._progress(Progress("publish", total, total))

    def _create(self, path: str, data: bytes) -> str | None:
        """Put a file unless it is there, and return its entity tag; None if it was there, or the store has no tags."""
        try:
            return obstore.put(self._store, path, data, mode="create")["e_tag"]
        except AlreadyExistsError:
            return None


def _chunk_names(manifest: bytes) -> frozenset[str]:
    return frozenset(stored_sizes(parse_manifest(manifest)[1]))


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", ENCODE_AGAIN) from error
