"""The bytes of a file that is to be read."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["file_bytes"]


def file_bytes(path: Path, kind: str) -> bytes:
    """Return the bytes of a file; `kind` names the expected kind of file, like "a .splat file".

    Raises:
        InputError: it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", f"give {kind}") from error
