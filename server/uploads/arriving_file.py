"""A file that arrives in consecutive pieces and is verified against its announced hash."""

from __future__ import annotations

import hashlib
import os
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from server.http.problems import ProblemError

__all__ = ["ArrivingFile"]

_BLOCK = 1 << 20  # bytes per read


@dataclass
class ArrivingFile:
    """One file of an upload; safe to use from several threads.

    Received bytes are in `<number>.part`; after the last byte the SHA-256 is verified and the file becomes `<number>`.
    The length of the part is the offset, so a killed server continues from there.
    """

    number: int
    path: str  # relative to the capture, as returned by `normal_path`
    size: int  # bytes
    sha256: str  # SHA-256 of the whole content, 64 lower-case hex digits
    folder: Path  # folder of the upload's data
    offset: int = 0  # received bytes
    verified: bool = False  # complete, with the right hash
    _turn: int = 0  # number of senders so far; the last one may write
    _hash: Any = None  # running hash, if all bytes arrived since the server started
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def look(self) -> None:
        """Restore the state from the disk after a start of the server."""
        self._hash = None
        self.verified = self.whole.is_file()
        self.offset = self.size if self.verified else self.part.stat().st_size if self.part.is_file() else 0
        if self.offset > self.size:
            self._begin_again()

    @property
    def part(self) -> Path:
        """The file's path while it is incomplete."""
        return self.folder / f"{self.number}.part"

    @property
    def whole(self) -> Path:
        """The file's path once its hash is verified."""
        return self.folder / str(self.number)

    def begin(self, offset: int) -> int:
        """Return a turn for `append`; it invalidates earlier turns.

        Raises:
            ProblemError: 409, the file does not end at `offset`.
        """
        with self._lock:
            if offset != self.offset:
                detail = f"{self.path[:80]!r} has {self.offset} bytes, not {offset}; continue from there"
                headers = {"Upload-Offset": str(self.offset)}
                raise ProblemError(409, "offset-mismatch", detail, field="Upload-Offset", headers=headers)
            self._turn += 1
            return self._turn

    def append(self, turn: int, data: bytes) -> None:
        """Append bytes, and verify the hash once the file is complete.

        Raises:
            ProblemError: 409 another client is sending this file; 413 more bytes than announced; 422 the content
                does not match the announced hash, and is dropped.
            OSError: the disk is full.
        """
        with self._lock:
            if turn != self._turn:
                detail = f"{self.path[:80]!r}: another request sends this file; get its offset, and continue from there"
                raise ProblemError(409, "offset-mismatch", detail, field="Upload-Offset")
            if self.offset + len(data) > self.size:
                detail = f"{self.path[:80]!r}: more bytes than the {self.size} announced; announce the file again"
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
        """Verify the hash of a complete file, such as after a restart of the server.

        Raises:
            ProblemError: 422, it is wrong; the file starts over.
        """
        with self._lock:
            if self.offset == self.size and not self.verified:
                self._verify()

    def discard(self) -> None:
        """Delete the received bytes; its sender gets an error."""
        with self._lock:
            self._turn += 1
            self._begin_again()
            self.whole.unlink(missing_ok=True)

    def _verify(self) -> None:
        found = self._hash.hexdigest() if self._hash is not None else _sha256(self.part)
        if found != self.sha256:
            self._begin_again()
            detail = (
                f"{self.path[:80]!r}: the data has the SHA-256 {found}, not {self.sha256}: it changed in transit "
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
    # An empty file has no part.
    if path.is_file():
        with path.open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    return digest.hexdigest()
