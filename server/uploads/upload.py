"""One upload: its announced files and received bytes, in a folder that outlives the server.

```
<id>/upload.json    the announcement; its modification time is that of the last byte
<id>/files.jsonl    one line per announced file; the last line of a path counts
<id>/data/<number>  content of a file; <number>.part while bytes are missing
<id>/capture/       the files under their names, while the upload becomes a capture
```
"""

from __future__ import annotations

import json
import os
import shutil
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from hgs_core.base.atomic import write_bytes
from server.http.problems import ProblemError
from server.uploads.arriving_file import ArrivingFile
from server.uploads.journal import FileJournal
from server.uploads.names import FolderNames, normal_path
from server.uploads.upload_limits import UploadLimits, bytes_for_people

__all__ = ["Announcement", "Upload"]


@dataclass(frozen=True)
class Announcement:
    """A client's announcement of an upload."""

    name: str  # name of the capture
    files: int
    bytes: int
    key: str  # chosen by the client: the same key continues the same upload


class Upload:
    """An upload on disk with its index in memory; safe to use from several threads."""

    def __init__(self, folder: Path, announced: Announcement, created: float, capture: str, client: str) -> None:
        """Use `create` or `load`."""
        self.id = folder.name
        self.folder = folder
        self.announced = announced
        self.created = created
        self.client = client  # owner for `UploadLimits.client`; "": none
        self.capture = capture  # name of its capture folder; "" before it is one
        self.last_byte = created
        self.finishing = threading.RLock()  # held while it becomes a capture or is deleted
        self._data = folder / "data"
        self._tree = folder / "capture"
        self._journal = FileJournal(folder / "files.jsonl")
        self._files: list[ArrivingFile | None] = []  # place: number of the file; None: replaced
        self._by_path: dict[str, ArrivingFile] = {}
        self._names = FolderNames()
        self._total = 0  # total size of the files in `_by_path`, bytes
        self._lock = threading.RLock()

    @classmethod
    def create(cls, folder: Path, announced: Announcement, client: str = "") -> Self:
        """Create the upload's folder."""
        upload = cls(folder, announced, time.time(), "", client)
        (folder / "data").mkdir(parents=True)
        upload._save()
        return upload

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Load an upload of an earlier server process.

        Raises:
            OSError, ValueError, KeyError, TypeError: it is damaged.
        """
        told = json.loads((folder / "upload.json").read_text())
        announced = Announcement(**{name: told[name] for name in Announcement.__dataclass_fields__})
        upload = cls(folder, announced, float(told["created"]), str(told["capture"]), str(told.get("client", "")))
        upload.last_byte = (folder / "upload.json").stat().st_mtime
        if not upload.capture:
            upload._read_journal()
        return upload

    @property
    def received(self) -> int:
        """Number of received bytes."""
        return self.announced.bytes if self.capture else sum(file.offset for file in self._by_path.values())

    def describe(self, limits: UploadLimits) -> dict[str, Any]:
        """Return the upload object of docs/upload.md, without its capture's path."""
        with self._lock:
            done = sum(file.verified for file in self._by_path.values())
            return {
                "id": self.id,
                "name": self.announced.name,
                "state": "finished" if self.capture else "receiving",
                "files": self.announced.files,
                "bytes": self.announced.bytes,
                "received": self.received,
                "verified": self.announced.files if self.capture else done,
                "created": self.created,
                "expires": None if self.capture else self.last_byte + 3600 * limits.hours,
            }

    def describe_files(self) -> list[dict[str, Any]]:
        """Return announced size and received bytes of every file."""
        with self._lock:
            if self.capture:
                there = {told["path"]: told for told in self._journal.read()}
                return [
                    {"number": number, **told, "offset": told["size"], "verified": True}
                    for number, told in enumerate(there.values())
                ]
            return [
                {name: getattr(file, name) for name in ("number", "path", "size", "sha256", "offset", "verified")}
                for file in self._by_path.values()
            ]

    def add(self, path: str, size: int, sha256: str, limits: UploadLimits) -> ArrivingFile:
        """Announce a file; the same again returns the same file, and another size or hash replaces it.

        Raises:
            ProblemError: 409 the name is taken or the upload is finished, 413 too large, 422 invalid name.
        """
        path = normal_path(path)
        limits.check_file(path, size)
        with self._lock:
            self.require_unfinished()
            known = self._by_path.get(path)
            if known is not None and (known.size, known.sha256) == (size, sha256):
                return known
            self._check_totals(path, size, known)
            self._names.add(path)
            if known is not None:
                self._forget(known)
            self._journal.add(path, size, sha256)
            file = self._index(path, size, sha256)
            if size == 0:
                file.verify()
            return file

    def file(self, number: int) -> ArrivingFile:
        """Return a file by its number.

        Raises:
            ProblemError: 404.
        """
        found = self._files[number] if 0 <= number < len(self._files) else None
        if found is None:
            raise ProblemError(404, "file-not-found", f"upload {self.id}: no file {number}")
        return found

    def heard_of(self) -> None:
        """Record that bytes have arrived: an upload without any for long is deleted."""
        self.last_byte = time.time()
        os.utime(self.folder / "upload.json", (self.last_byte, self.last_byte))

    def assemble(self) -> Path:
        """Verify remaining files, give all their names, and return the folder; may be repeated.

        Raises:
            ProblemError: 409 files or bytes are missing; 422 a file's content does not match its hash.
        """
        with self._lock:
            self.require_unfinished()
            files = list(self._by_path.values())
        for file in files:  # holds no lock: this may read the whole file again
            file.verify()
        with self._lock:
            self._require_complete()
            for file in self._by_path.values():
                target = self._tree / file.path
                if file.whole.is_file():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    file.whole.replace(target)
            return self._tree

    def finish(self, capture: str) -> None:
        """Record the name of the capture."""
        with self._lock:
            self.capture = capture
            self._save()

    def drop_data(self) -> None:
        """Delete data that a finished upload no longer needs."""
        with self._lock:
            self._files, self._by_path, self._names = [], {}, FolderNames()
            shutil.rmtree(self._data, ignore_errors=True)

    def require_unfinished(self) -> None:
        """Reject changes of a finished upload.

        Raises:
            ProblemError: 409.
        """
        if self.capture:
            raise ProblemError(409, "upload-finished", f"upload {self.id}: is already a capture; start another upload")

    def _check_totals(self, path: str, size: int, known: ArrivingFile | None) -> None:
        count, total = len(self._by_path) + (known is None), self._total + size - (known.size if known else 0)
        if count > self.announced.files:
            limit = f"{path[:80]!r} is one file more than the {self.announced.files} announced for this upload"
            raise ProblemError(413, "upload-too-large", f"{limit}; start another upload", field="files")
        if total > self.announced.bytes:
            announced = f"{self.announced.bytes:,} bytes announced"
            limit = f"{path[:80]!r} makes {bytes_for_people(total)}, more than the {announced}"
            raise ProblemError(413, "upload-too-large", f"{limit}; start another upload", field="bytes")

    def _require_complete(self) -> None:
        missing = self.announced.files - len(self._by_path)
        if missing:
            detail = f"upload {self.id}: {missing} of {self.announced.files} files are not announced yet; send them"
            raise ProblemError(409, "upload-incomplete", detail)
        open_files = [file.path for file in self._by_path.values() if not file.verified]
        if open_files:
            detail = (
                f"upload {self.id}: bytes of {len(open_files)} files are missing, {open_files[0][:80]!r} among them"
            )
            raise ProblemError(409, "upload-incomplete", detail + "; send them")

    def _save(self) -> None:
        told = asdict(self.announced) | {"created": self.created, "capture": self.capture, "client": self.client}
        write_bytes(self.folder / "upload.json", json.dumps(told, indent=1).encode())

    def _index(self, path: str, size: int, sha256: str) -> ArrivingFile:
        file = ArrivingFile(len(self._files), path, size, sha256, self._data)
        self._files.append(file)
        self._by_path[path] = file
        self._total += size
        return file

    def _forget(self, file: ArrivingFile) -> None:
        file.discard()
        (self._tree / file.path).unlink(missing_ok=True)
        self._files[file.number] = None
        self._total -= file.size

    def _read_journal(self) -> None:
        for told in self._journal.read():
            before = self._by_path.get(told["path"])
            self._names.add(told["path"])
            if before is not None:
                self._forget(before)
            self._index(told["path"], told["size"], told["sha256"])
        for file in self._by_path.values():
            file.look()
            # The server was killed while it named the files.
            if not file.verified and (self._tree / file.path).is_file():
                file.offset, file.verified = file.size, True
            elif file.size == 0:
                file.verify()
