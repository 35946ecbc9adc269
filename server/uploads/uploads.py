"""All uploads of a home: creation, continuation, conversion to captures, and deletion of abandoned ones."""

from __future__ import annotations

import fcntl
import logging
import secrets
import shutil
import threading
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO

from jobs.queue.job_request import readable_id
from jobs.runs.stored_captures import StoredCaptures
from server.http.problems import ProblemError
from server.uploads.names import capture_name
from server.uploads.upload import Announcement, Upload
from server.uploads.upload_limits import UploadLimits, bytes_for_people

__all__ = ["Uploads"]

_TRASH = ".deleted-"
_CAPTURES = "captures"  # not an upload's id: those end in a hyphen and eight digits

log = logging.getLogger("hgs.server")


class Uploads:
    """Uploads in a folder; safe to use from several threads, by one process at a time."""

    def __init__(
        self, folder: Path, limits: UploadLimits | None = None, everywhere: StoredCaptures | None = None
    ) -> None:
        """Read nothing yet; the folder is created with the first upload.

        `everywhere` is the shared store of captures, for machines that do not share the folder.
        """
        self._everywhere = everywhere
        self.folder = folder
        self.captures = folder / _CAPTURES
        self.limits = limits or UploadLimits()
        self._uploads: dict[str, Upload] = {}
        self._held: BinaryIO | None = None
        self._lock = threading.RLock()

    def begin(self, announced: Announcement, client: str = "") -> tuple[Upload, bool]:
        """Return the unfinished upload with this announcement, or a new one for `client`; and whether it is new.

        Raises:
            ProblemError: 403, 413, 429, 503 or 507: the announcement exceeds a limit, by itself or
                together with other uploads.
        """
        self.limits.check_upload(announced.files, announced.bytes)
        self.sweep()
        with self._lock:
            self._open()
            unfinished = [upload for upload in self._uploads.values() if not upload.capture]
            for upload in unfinished:
                if upload.announced == announced:
                    return upload, False
            self._check_room(announced, unfinished, client)
            upload = Upload.create(self.folder / readable_id(announced.name, "upload"), announced, client)
            self._uploads[upload.id] = upload
            log.info("upload %s begins: %d files, %d bytes", upload.id, announced.files, announced.bytes)
            return upload, True

    def get(self, upload_id: str) -> Upload:
        """Return an upload.

        Raises:
            ProblemError: 404; 503, another process manages the uploads.
        """
        with self._lock:
            self._open()
            upload = self._uploads.get(upload_id)
        if upload is None:
            detail = f"upload {upload_id[:80]!r}: no such upload; it was deleted, or expired without new data"
            raise ProblemError(404, "upload-not-found", detail)
        return upload

    def all(self) -> list[Upload]:
        """Return the uploads, the newest first."""
        self.sweep()
        with self._lock:
            return sorted(self._uploads.values(), key=lambda upload: upload.created, reverse=True)

    def describe(self, upload: Upload) -> dict[str, Any]:
        """Return the upload object of docs/upload.md."""
        path = str(self.captures / upload.capture) if upload.capture else None
        return upload.describe(self.limits) | {"capture": path}

    def require_room(self) -> None:
        """Reject further bytes when the disk is as full as uploads may make it.

        Raises:
            ProblemError: 507.
        """
        free = shutil.disk_usage(self.folder).free
        if free < self.limits.free:
            detail = (
                f"the server's disk has {bytes_for_people(free)} left; uploads must leave "
                f"{bytes_for_people(self.limits.free)} free (--uploads); received data is kept: continue later"
            )
            raise ProblemError(507, "storage-full", detail, headers={"Retry-After": "60"})

    def finish(self, upload: Upload) -> None:
        """Convert a complete upload to a capture, atomically; repeating it changes nothing.

        Raises:
            ProblemError: 409 it is not complete; 422 a file's content does not match its hash.
        """
        with upload.finishing:
            if upload.capture:
                return
            tree = upload.assemble()
            stored, refused = "", set[str]()
            while True:
                with self._lock:
                    self.captures.mkdir(exist_ok=True)
                    name = self._free_name(capture_name(upload.announced.name), refused)
                    if self._everywhere is None or name == stored:
                        upload.finish(name)
                        tree.rename(self.captures / name)
                        break
                # Without the lock: it takes as long as the capture is large. If interrupted, it is repeated.
                if self._everywhere.put(name, tree):
                    stored = name
                else:
                    refused.add(name.casefold())
            upload.drop_data()
        log.info("upload %s is the capture %s", upload.id, name)

    def delete(self, upload: Upload) -> None:
        """Delete an upload, and its capture if it has become one."""
        with upload.finishing:
            if upload.capture and self._everywhere is not None:
                self._everywhere.remove(upload.capture)
            with self._lock:
                if self._uploads.pop(upload.id, None) is None:
                    return
            if upload.capture and (self.captures / upload.capture).is_dir():
                self._discard(self.captures / upload.capture)
            self._discard(upload.folder)
        log.info("upload %s is deleted", upload.id)

    def sweep(self) -> None:
        """Delete abandoned uploads, and the remains of captures that are gone."""
        if not self.folder.is_dir():
            return
        with self._lock:
            self._open()
            gone = [upload for upload in self._uploads.values() if self._is_over(upload)]
        for upload in gone:
            with upload.finishing:
                if self._is_over(upload):  # still abandoned: it may just have become a capture
                    log.warning("deleting upload %s: no data for too long, or its capture is gone", upload.id)
                    self.delete(upload)

    def close(self) -> None:
        """Let another process manage the uploads."""
        with self._lock:
            self._uploads = {}
            if self._held is not None:
                self._held.close()
            self._held = None

    def _is_over(self, upload: Upload) -> bool:
        if upload.capture:
            return not (self.captures / upload.capture).is_dir()
        return upload.last_byte < time.time() - 3600 * self.limits.hours

    def _check_room(self, announced: Announcement, unfinished: list[Upload], client: str) -> None:
        limits = self.limits
        own = [upload for upload in unfinished if client and upload.client == client]
        if len(own) >= limits.client:
            detail = (
                f"{len(own)} unfinished uploads of this key or address; the limit is {limits.client} "
                f"(--uploads client); finish or delete one, such as {own[0].id}"
            )
            raise ProblemError(429, "uploads-open", detail, headers={"Retry-After": "60"})
        if len(unfinished) >= limits.open:
            detail = f"{limits.open} uploads are unfinished (--uploads open); finish or delete one, or try again later"
            raise ProblemError(503, "uploads-open", detail, headers={"Retry-After": "60"})
        held = sum(upload.announced.bytes for upload in self._uploads.values())
        share = sum(upload.announced.bytes for upload in self._uploads.values() if client and upload.client == client)
        limits.check_quota(announced.bytes, held, share)
        awaited = sum(upload.announced.bytes - upload.received for upload in unfinished)
        room = shutil.disk_usage(self.folder).free - awaited - limits.free
        if announced.bytes > room:
            detail = (
                f"the server's disk has room for {bytes_for_people(max(room, 0))} more, since uploads must leave "
                f"{bytes_for_people(limits.free)} free (--uploads free), and this one has "
                f"{bytes_for_people(announced.bytes)}; free some space"
            )
            raise ProblemError(507, "storage-full", detail, field="bytes")

    def _free_name(self, name: str, refused: Collection[str]) -> str:
        """Return the name, with a number if another capture has it, ignoring case, or if it was rejected."""
        taken = set(refused) | {path.name.casefold() for path in self.captures.iterdir()}
        taken |= {upload.capture.casefold() for upload in self._uploads.values()}
        number, found = 1, name
        while found.casefold() in taken:
            number += 1
            found = f"{name} {number}"
        return found

    def _open(self) -> None:
        """Load the uploads of an earlier process, once, and lock them against other processes."""
        if self._held is not None:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        held = (self.folder / "lock").open("ab")
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            held.close()
            detail = "another server process manages the uploads of this home; send them to that one"
            raise ProblemError(503, "uploads-elsewhere", detail, headers={"Retry-After": "5"}) from error
        self._held = held
        for path in self.folder.iterdir():
            if path.name.startswith(_TRASH):
                shutil.rmtree(path, ignore_errors=True)
            elif path.is_dir() and path.name != _CAPTURES:
                self._load(path)

    def _load(self, path: Path) -> None:
        try:
            upload = Upload.load(path)
        except (OSError, ValueError, KeyError, TypeError, ProblemError):
            log.exception("deleting upload %s, which cannot be read", path)
            self._discard(path)
            return
        self._uploads[upload.id] = upload
        tree = path / "capture"
        if upload.capture:  # killed during the last steps of `finish`
            if tree.is_dir() and not (self.captures / upload.capture).exists():
                self.captures.mkdir(exist_ok=True)
                tree.rename(self.captures / upload.capture)
            upload.drop_data()

    def _discard(self, path: Path) -> None:
        """Delete a folder; it disappears at once, however long the deletion takes."""
        trash = self.folder / f"{_TRASH}{secrets.token_hex(8)}"
        path.rename(trash)
        shutil.rmtree(trash, ignore_errors=True)
