"""The artifact store: published scenes and their chunks, in a folder or an object store such as S3.

Layout: `scenes/<scene id>/manifest.json`, `scenes/<scene id>/thumbnail.jpg` and `chunks/<sha256>`, the chunks shared by
all scenes. Nothing that was published is ever overwritten, but the manifest of a scene that grows by a later version.
A scene that was renamed has its new title beside it, in `scenes/<scene id>/title.txt`, and a long one its manifest in
pages, in `scenes/<scene id>/pages.bin`. These and `scenes/<scene id>/description.json`, the facts that lists show, are
made of the manifest, from which a server can make them again.
"""

from __future__ import annotations

import contextlib
import json
import logging
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit
from urllib.request import url2pathname

import obstore

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.codec.format.manifest_reading import parse_manifest
from hgs_core.codec.format.paging import PagedScene
from hgs_core.codec.format.scene_folder import MANIFEST, THUMBNAIL
from jobs.artifacts.publication import PAGES, Publication
from jobs.artifacts.publishing_lock import FileStoreLock, PostgresStoreLock, StoreLock
from jobs.artifacts.scene_description import DESCRIPTION, SceneDescription
from jobs.home.database import connection_url
from jobs.home.home import Home
from jobs.home.object_store import is_folder, open_object_store
from jobs.home.passing_faults import one_line

if TYPE_CHECKING:
    from obstore import ObjectMeta

__all__ = ["SCENE_ID", "ArtifactStore", "SceneEntry", "StoredChunk", "open_store"]

SCENE_ID = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
"""Of a scene, and of the job that makes it: they have the same."""

LONG = 64 << 10  # bytes of a manifest: shorter ones are read faster than another object of the store

_TITLE = "title.txt"

_CHUNK_ID = re.compile(r"[0-9a-f]{64}")

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class SceneEntry:
    """One published scene."""

    id: str
    published: datetime  # UTC
    version: str = ""  # another one, should another scene be published under the same id
    renamed: str = ""  # another one after every change of the title; empty while it has the first one
    tag: str = ""  # entity tag of the manifest; empty in a store without tags


@dataclass(frozen=True)
class StoredChunk:
    """One chunk in the store, whether a scene names it or not."""

    id: str
    size: int  # bytes
    stored: datetime  # UTC


class ArtifactStore:
    """Published scenes. Reads return None for names that do not exist, malformed ones included.

    Safe to use from several threads; every method blocks for its input and output.
    """

    def __init__(self, url: str, lock: StoreLock | None = None, *, once: bool = False) -> None:
        """Open file:///FOLDER (made if missing), s3://BUCKET/PREFIX or any other URL that obstore knows.

        `lock` is what all who publish to an object store share (`open_store`); a folder holds its own. With `once`, a
        server that does not answer is not asked again.
        """
        self._store = open_object_store(url, once=once)
        if is_folder(url):
            lock = FileStoreLock(Path(url2pathname(urlsplit(url).path)) / "store.lock")
        self._lock = lock

    @property
    def lock(self) -> StoreLock:
        """The lock between publishing and collecting.

        Raises:
            ValueError: the store was opened without one.
        """
        if self._lock is None:
            raise ValueError("an object store is collected with the lock of its home alone; use open_store")
        return self._lock

    def put_scene(self, folder: Path, scene_id: str, progress: ProgressCallback = silent) -> None:
        """Publish an encoded scene: its chunks, then the thumbnail, then the manifest.

        Every chunk is decoded before it is stored, and the manifest comes last, so whoever sees the scene sees all of
        it. Publishing again does nothing, but where the scene there is an earlier version of this one: then what is new
        is added. Of one scene, publish one version at a time.

        Raises:
            InputError: a malformed scene id, an unreadable manifest, or a file that is missing or damaged. The store
                may then hold chunks that no scene names.
        """
        if not SCENE_ID.fullmatch(scene_id):
            raise InputError("scene id", f"{scene_id!r} is not 1 to 64 of a-z, 0-9, _ and -, beginning with a-z or 0-9")
        publication = Publication(self._store, folder, scene_id, progress)
        if self._lock is None:
            publication.put(self.manifest(scene_id), lambda: None)
            return
        with self._lock.publishing(publication.waits) as require_lock:
            publication.put(self.manifest(scene_id), require_lock)

    def list_scenes(self) -> list[SceneEntry]:
        """Return the published scenes, newest first."""
        manifests: dict[str, ObjectMeta] = {}
        titles: dict[str, ObjectMeta] = {}
        for page in obstore.list(self._store, prefix="scenes"):
            for item in page:
                parts = item["path"].split("/")
                if len(parts) == 3 and SCENE_ID.fullmatch(parts[1]) and parts[2] in (MANIFEST, _TITLE):
                    (manifests if parts[2] == MANIFEST else titles)[parts[1]] = item
        scenes = [_entry(scene_id, item, titles.get(scene_id)) for scene_id, item in manifests.items()]
        return sorted(scenes, key=lambda scene: (scene.published, scene.id), reverse=True)

    def scene_entry(self, scene_id: str) -> SceneEntry | None:
        """Return one published scene as `list_scenes` does, without a look at the others."""
        if not SCENE_ID.fullmatch(scene_id):
            return None
        item = self._head(f"scenes/{scene_id}/{MANIFEST}")
        return None if item is None else _entry(scene_id, item, self._head(f"scenes/{scene_id}/{_TITLE}"))

    def manifest(self, scene_id: str) -> bytes | None:
        """Return the bytes of a scene's manifest.json."""
        return self._get(f"scenes/{scene_id}/{MANIFEST}") if SCENE_ID.fullmatch(scene_id) else None

    def describe(self, entry: SceneEntry) -> SceneDescription | None:
        """Return a scene's description, or None if the scene is gone.

        Costs one small read. Where the description is missing or of another manifest it is made of the manifest, and
        written if the store can be written.

        Raises:
            InputError: the manifest is damaged or of another version.
        """
        path = f"scenes/{entry.id}/{DESCRIPTION}"
        data = self._get(path)
        described = None if data is None else SceneDescription.unpacked(data, entry.tag)
        if described is not None:
            return described
        try:
            found = obstore.get(self._store, f"scenes/{entry.id}/{MANIFEST}")
        except FileNotFoundError:
            return None
        manifest, tag = bytes(found.bytes()), found.meta["e_tag"]
        if self.pages(entry.id, manifest) is not None:  # a published and checked manifest
            document = json.loads(manifest)
        else:
            document, _ = parse_manifest(manifest, f"manifest of scene {entry.id}")
        described = SceneDescription.of(document, len(manifest))
        if tag is not None:
            try:
                obstore.put(self._store, path, described.packed(tag))
            except Exception as error:  # any exception of the store: the next process reads the manifest again
                log.info("the description of scene %s was not written: %s", entry.id, one_line(error))
        return described

    def pages(self, scene_id: str, manifest: bytes) -> PagedScene | None:
        """Return a long scene's manifest, of these bytes, in the pages made at its publication; None without them."""
        if len(manifest) < LONG or not SCENE_ID.fullmatch(scene_id):
            return None
        data = self._get(f"scenes/{scene_id}/{PAGES}")
        return None if data is None else PagedScene.unpacked(data, manifest)

    def thumbnail(self, scene_id: str) -> bytes | None:
        """Return the bytes of a scene's JPEG thumbnail."""
        return self._get(f"scenes/{scene_id}/{THUMBNAIL}") if SCENE_ID.fullmatch(scene_id) else None

    def title(self, scene_id: str) -> str | None:
        """Return the title that a scene was given after its publication, if it was."""
        data = self._get(f"scenes/{scene_id}/{_TITLE}") if SCENE_ID.fullmatch(scene_id) else None
        return None if data is None else data.decode("utf-8", "replace")

    def rename_scene(self, scene_id: str, title: str) -> None:
        """Give a published scene another title; its manifest stays as it is. Unknown ids are ignored."""
        if self.scene_entry(scene_id) is not None:
            obstore.put(self._store, f"scenes/{scene_id}/{_TITLE}", title.encode())

    def chunk(self, chunk_id: str) -> bytes | None:
        """Return the bytes of the chunk with this SHA-256 (64 lower-case hexadecimal digits)."""
        return self._get(f"chunks/{chunk_id}") if _CHUNK_ID.fullmatch(chunk_id) else None

    def list_chunks(self) -> Iterator[StoredChunk]:
        """Yield every chunk in the store."""
        for page in obstore.list(self._store, prefix="chunks"):
            for item in page:
                name = item["path"].rpartition("/")[2]
                if _CHUNK_ID.fullmatch(name) and item["path"] == f"chunks/{name}":
                    yield StoredChunk(name, item["size"], item["last_modified"])

    def remove_chunks(self, chunk_ids: Sequence[str]) -> None:
        """Remove chunks that no scene names; only `jobs.artifacts.chunk_collection` can know that."""
        for chunk_id in chunk_ids:
            if not _CHUNK_ID.fullmatch(chunk_id):
                raise ValueError(chunk_id)
        with contextlib.suppress(FileNotFoundError):
            obstore.delete(self._store, [f"chunks/{chunk_id}" for chunk_id in chunk_ids])

    def remove_scene(self, scene_id: str) -> None:
        """Take a scene back; unknown ids are ignored. Its chunks stay, since other scenes may name them too."""
        if SCENE_ID.fullmatch(scene_id):
            for name in (MANIFEST, THUMBNAIL, _TITLE, PAGES, DESCRIPTION):
                try:
                    obstore.delete(self._store, f"scenes/{scene_id}/{name}")
                except FileNotFoundError:
                    continue

    def _head(self, path: str) -> ObjectMeta | None:
        try:
            return obstore.head(self._store, path)
        except FileNotFoundError:
            return None

    def _get(self, path: str) -> bytes | None:
        try:
            return bytes(obstore.get(self._store, path).bytes())
        except FileNotFoundError:
            return None


def open_store(home: Home) -> ArtifactStore:
    """Return the store of a home, with the lock that all processes of the home share."""
    if home.runs_in_store:
        return ArtifactStore(home.store_url, PostgresStoreLock(connection_url(home)))
    return ArtifactStore(home.store_url, FileStoreLock(home.folder / "store.lock"))


def _entry(scene_id: str, manifest: ObjectMeta, title: ObjectMeta | None) -> SceneEntry:
    renamed = "" if title is None else _version(title)
    return SceneEntry(scene_id, manifest["last_modified"], _version(manifest), renamed, manifest["e_tag"] or "")


def _version(item: ObjectMeta) -> str:
    # Whole seconds: object stores give fractions in a listing, and none where they are asked for one object.
    return f"{int(item['last_modified'].timestamp())} {item['size']} {item['e_tag']}"
