"""A run in the object store: objects that never change, and a head that names those which are its state.

```
<prefix>/head.json           which epoch has the run, and every file with the object that is its content
<prefix>/<epoch>/<sha256>    the content of a file, put there under that epoch
```

The head is replaced by conditional put alone: only whoever has read the present one can put the next. The epoch comes
from the job table, which counts it up whenever a worker takes the job; a worker whose epoch is below the head's has
lost the run, whatever it believes itself.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO

import obstore
from obstore.exceptions import AlreadyExistsError, PreconditionError
from obstore.store import ObjectStore

from hgs_core.base.errors import InputError

__all__ = ["RunHead", "RunTakenError", "StoredFile", "StoredRun"]

_HEAD = "head.json"
_OBJECT = re.compile(r"\d+/[0-9a-f]{64}")
_BLOCK = 4 << 20  # bytes read at once
_BATCH = 1000  # objects removed by one request


class RunTakenError(Exception):
    """Another process has the run now: nothing that happens here may be saved any more."""


@dataclass(frozen=True)
class StoredFile:
    """The content of one file."""

    epoch: int  # epoch of the put
    sha256: str  # 64 lower-case hexadecimal digits
    size: int  # bytes

    @property
    def name(self) -> str:
        """Of the object, below the run's prefix."""
        return f"{self.epoch}/{self.sha256}"


@dataclass(frozen=True)
class RunHead:
    """The head of a stored run."""

    epoch: int
    files: Mapping[str, StoredFile] = field(default_factory=dict)  # path below the run folder -> file
    complete: bool = False  # nothing will follow; of a segment: it is made
    free: bool = False  # whoever had it has given it up
    tag: str = ""  # the object's ETag, for the next conditional put

    def to_json(self) -> dict[str, Any]:
        """Return the content of the object, without its tag."""
        files = {name: [file.epoch, file.sha256, file.size] for name, file in self.files.items()}
        return {"epoch": self.epoch, "complete": self.complete, "free": self.free, "files": files}


class StoredRun:
    """The run, or a segment of one, that lies under `prefix`.

    Methods block; errors of the store are raised as they are. Safe to use from several threads.
    """

    def __init__(self, store: ObjectStore, prefix: str) -> None:
        self._store = store
        self.prefix = prefix

    def head(self) -> RunHead | None:
        """Return the present head, or None if there is no such run.

        Raises:
            InputError: it is damaged.
        """
        try:
            answer = obstore.get(self._store, f"{self.prefix}/{_HEAD}")
        except FileNotFoundError:
            return None
        text, tag = bytes(answer.bytes()), answer.meta["e_tag"] or ""
        try:
            value = json.loads(text)
            files = {str(name): StoredFile(*map(_exactly, file)) for name, file in value["files"].items()}
            return RunHead(int(value["epoch"]), files, bool(value["complete"]), bool(value["free"]), tag)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            where = f"the store's {self.prefix}/{_HEAD}"
            raise InputError(where, f"is damaged ({error!r})", "delete the job and submit it again") from error

    def create(self, head: RunHead) -> RunHead:
        """Put the first head.

        Raises:
            RunTakenError: there is one.
        """
        return self._put(head, "create")

    def replace(self, before: RunHead, after: RunHead) -> RunHead:
        """Put `after` in the place of `before`, and return it with its tag.

        Raises:
            RunTakenError: the head is not `before` any more.
        """
        return self._put(after, {"e_tag": before.tag})

    def _put(self, head: RunHead, mode: Any) -> RunHead:
        # The same words twice would have the same tag, and a tag must name one moment.
        text = json.dumps(head.to_json() | {"nonce": secrets.token_hex(8)}, separators=(",", ":")).encode()
        path = f"{self.prefix}/{_HEAD}"
        try:
            put = obstore.put(self._store, path, text, mode=mode, use_multipart=False)
            return replace(head, tag=put["e_tag"] or "")
        except (AlreadyExistsError, PreconditionError, FileNotFoundError) as error:
            # The library asks again where an answer was lost, and is then refused what it has already got.
            try:
                there = obstore.get(self._store, path)
            except FileNotFoundError:
                raise RunTakenError(f"{self.prefix}: the run is gone") from error
            if bytes(there.bytes()) == text:
                return replace(head, tag=there.meta["e_tag"] or "")
            raise RunTakenError(f"{self.prefix}: another process has taken this run over") from error

    def put_file(
        self, epoch: int, file: BinaryIO, known: StoredFile | None = None, *, growing: bool = False
    ) -> StoredFile:
        """Put the content of a file that is open for reading, unless it is that of `known`.

        Of one that grows it is what it has at this moment.
        """
        if growing:
            return self.put_bytes(epoch, file.read(), known)
        digest, size = hashlib.sha256(), 0
        while block := file.read(_BLOCK):
            digest.update(block)
            size += len(block)
        file.seek(0)
        return self._put_object(StoredFile(epoch, digest.hexdigest(), size), file, known)

    def put_bytes(self, epoch: int, data: bytes, known: StoredFile | None = None) -> StoredFile:
        """Put a content, unless it is that of `known`."""
        return self._put_object(StoredFile(epoch, hashlib.sha256(data).hexdigest(), len(data)), data, known)

    def _put_object(self, file: StoredFile, content: Any, known: StoredFile | None) -> StoredFile:
        if known is not None and known.sha256 == file.sha256:
            return known
        obstore.put(self._store, f"{self.prefix}/{file.name}", content)
        return file

    def is_content(self, known: StoredFile, file: BinaryIO) -> bool:
        """Return whether a file that is open for reading has the content of `known`."""
        digest = hashlib.sha256()
        while block := file.read(_BLOCK):
            digest.update(block)
        return digest.hexdigest() == known.sha256

    def fetch(self, file: StoredFile, part: Path) -> None:
        """Write the content of a file to `part`; if that holds the beginning already, only the rest is asked for.

        Raises:
            FileNotFoundError: the object is gone, as it is once a later head does not name it.
            InputError: the object is damaged.
        """
        digest, there = hashlib.sha256(), 0
        if part.exists():
            there = part.stat().st_size
            if there > file.size:
                part.unlink()
                there = 0
        with part.open("ab+") as local:
            local.seek(0)
            while block := local.read(_BLOCK):
                digest.update(block)
            if there < file.size:
                answer = obstore.get(self._store, f"{self.prefix}/{file.name}", options={"range": (there, file.size)})
                for piece in answer.stream(_BLOCK):
                    local.write(piece)
                    digest.update(piece)
        if digest.hexdigest() != file.sha256:
            part.unlink()
            raise self._damaged(file)

    def read(self, file: StoredFile) -> bytes:
        """Return the content of a small file, checked as `fetch` does."""
        data = bytes(obstore.get(self._store, f"{self.prefix}/{file.name}").bytes()) if file.size else b""
        if hashlib.sha256(data).hexdigest() != file.sha256:
            raise self._damaged(file)
        return data

    def _damaged(self, file: StoredFile) -> InputError:
        where = f"the store's {self.prefix}/{file.name}"
        return InputError(where, "is damaged: its SHA-256 is another", "delete the job and submit it again")

    def remove_superseded(self, head: RunHead) -> None:
        """Remove the objects of this epoch and earlier ones that the head does not name."""
        named = {file.name for file in head.files.values()}
        gone = [name for name in self._objects() if name not in named and int(name.partition("/")[0]) <= head.epoch]
        self._delete([f"{self.prefix}/{name}" for name in gone])

    def remove_files(self, files: list[StoredFile]) -> None:
        """Remove objects that no head names any more."""
        self._delete([f"{self.prefix}/{file.name}" for file in files])

    def remove(self) -> None:
        """Remove the run, segments included: the head first, so that a process at work finds it gone."""
        self._delete([f"{self.prefix}/{_HEAD}"])
        self._delete([item["path"] for page in obstore.list(self._store, prefix=self.prefix) for item in page])

    def _objects(self) -> list[str]:
        found = []
        for page in obstore.list(self._store, prefix=self.prefix):
            names = (item["path"].removeprefix(f"{self.prefix}/") for item in page)
            found += [name for name in names if _OBJECT.fullmatch(name)]
        return found

    def _delete(self, paths: list[str]) -> None:
        for start in range(0, len(paths), _BATCH):
            with contextlib.suppress(FileNotFoundError):
                obstore.delete(self._store, paths[start : start + _BATCH])


def _exactly(value: Any) -> Any:
    if not isinstance(value, (int, str)):
        raise TypeError(value)
    return value
