"""The bytes of a file that is to be read."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["file_bytes"]


def file_bytes(path: Path, kind: str) -> bytes:
    """Return what a file holds; `kind` tells which kind of file was hoped for, like "a .splat file".

    Raises:
        InputError: it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", f"give {kind}") from error
