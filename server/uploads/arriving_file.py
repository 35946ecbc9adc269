"""A file that arrives in pieces, each behind the last, until its content is the one that was announced."""

from __future__ import annotations

import hashlib
import os
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from server.http.problems import ProblemError

__all__ = ["ArrivingFile"]

_BLOCK = 1 << 20  # bytes that are read at once


@dataclass
class ArrivingFile:
    """One file of an upload; safe to use from several threads.

    What has come lies in `<number>.part`; with the last byte its SHA-256 is compared, and it becomes `<number>`. The
    length of the part is how far it is, so that a server that was killed goes on from there.
    """

    number: int
    path: str  # below the capture, as `normal_path` returns it
    size: int  # bytes
    sha256: str  # of the whole content, 64 lower-case hex digits
    folder: Path  # of the upload's data
    offset: int = 0  # bytes that have come
    verified: bool = False  # all have come, and the hash is right
    _turn: int = 0  # counts those who began to send; the last one may write
    _hash: Any = None  # of the bytes that came since the server started, if those are all
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def look(self) -> None:
        """Find out what there is on disk, after a start of the server."""
        self._hash = None
        self.verified = self.whole.is_file()
        self.offset = self.size if self.verified else self.part.stat().st_size if self.part.is_file() else 0
        if self.offset > self.size:
            self._begin_again()

    @property
    def part(self) -> Path:
        """The file while it is not complete."""
        return self.folder / f"{self.number}.part"

    @property
    def whole(self) -> Path:
        """The file once its hash was found right."""
        return self.folder / str(self.number)

    def begin(self, offset: int) -> int:
        """Return a turn to `append` with; who had one before has it no longer.

        Raises:
            ProblemError: 409, the file does not end at `offset`.
        """
        with self._lock:
            if offset != self.offset:
                detail = f"{self.path[:80]!r} has {self.offset} bytes, not {offset}; go on from there"
                headers = {"Upload-Offset": str(self.offset)}
                raise ProblemError(409, "offset-mismatch", detail, field="Upload-Offset", headers=headers)
            self._turn += 1
            return self._turn

    def append(self, turn: int, data: bytes) -> None:
        """Write bytes behind those that have come, and check the hash once all are there.

        Raises:
            ProblemError: 409 another client sends this file now; 413 more bytes than were announced; 422 the content is
                not the one that was announced: none of it is kept.
            OSError: the disk is full.
        """
        with self._lock:
            if turn != self._turn:
                detail = f"{self.path[:80]!r}: another request sends this file; ask how far it is, and go on from there"
                raise ProblemError(409, "offset-mismatch", detail, field="Upload-Offset")
            if self.offset + len(data) > self.size:
                detail = f"{self.path[:80]!r}: more bytes than the {self.size} that were announced; announce it anew"
                raise ProblemError(413, "upload-too-large", detail, field="Upload-Length")
            if self.offset == 0:
                self._hash = hashlib.sha256()
            try:
                with self.part.open("ab") as file:
                    file.write(data)
            except OSError:
                self._hash = None
                self.offset = self.part.stat().st_size if self.part.is_file() else 0
                raise
            self.offset += len(data)
            if self._hash is not None:
                self._hash.update(data)
            if self.offset == self.size:
                self._verify()

    def verify(self) -> None:
        """Check the hash of a file of which all bytes are there, as after a start of the server in that moment.

        Raises:
            ProblemError: 422, it is wrong; the file begins anew.
        """
        with self._lock:
            if self.offset == self.size and not self.verified:
                self._verify()

    def discard(self) -> None:
        """Delete what has come; whoever sends it is told."""
        with self._lock:
            self._turn += 1
            self._begin_again()
            self.whole.unlink(missing_ok=True)

    def _verify(self) -> None:
        found = self._hash.hexdigest() if self._hash is not None else _sha256(self.part)
        if found != self.sha256:
            self._begin_again()
            detail = (
                f"{self.path[:80]!r}: what came has the SHA-256 {found}, not {self.sha256}: it was changed on the way "
                "or while it was read; send it again from its first byte"
            )
            raise ProblemError(422, "checksum-mismatch", detail, field="sha256")
        with self.part.open("ab") as file:
            os.fsync(file.fileno())
        self.part.replace(self.whole)
        self.verified = True
        self._hash = None

    def _begin_again(self) -> None:
        self.part.unlink(missing_ok=True)
        self.offset, self.verified, self._hash = 0, False, None


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    if path.is_file():  # not where no byte was announced, and none has come
        with path.open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()
