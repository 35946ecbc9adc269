"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

__all__ = ["replacing", "write_bytes"]

_SHOWN = 40  # characters of the name in the temporary one, which must not become too long


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file beside `path` for writing; on success it replaces `path`, on an exception it is removed.

    The bytes are on disk before the name is, so that a power cut leaves the old file or the new one. The folder is
    made if it is missing.

    Raises:
        OSError: the folder cannot be made or written, or the disk is full; its `filename` is `path` or the folder.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.parent / f".{path.name[:_SHOWN]}.{secrets.token_hex(6)}.tmp"
    try:
        with temporary.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        fault = _fault_of_writing(error, temporary)
        if fault is None:
            raise
        raise OSError(fault.errno, fault.strerror, str(path)) from error


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` to `path` atomically.

    Raises:
        OSError: as `replacing`.
    """
    with replacing(path) as file:
        file.write(data)


def _fault_of_writing(error: BaseException, temporary: Path) -> OSError | None:
    """Return the system's error that an exception is or came of: torch.save hides it behind one of its own."""
    seen: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in seen:
        seen.add(id(cause))
        if isinstance(cause, OSError) and cause.errno is not None and cause.filename in (None, str(temporary)):
            return cause
        cause = cause.__cause__ or cause.__context__
    return None
