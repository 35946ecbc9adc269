"""Places that a command will write to, tried before its work begins: nobody waits an hour for "permission denied"."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.base.system_errors import as_input_error

__all__ = ["require_writable_file", "require_writable_folder"]

_BLOCK = bytes(4096)  # a full disk may still take an empty file


def require_writable_folder(folder: Path) -> None:
    """Try to write a file in a folder, made for that with those above it; afterwards all is as it was.

    Raises:
        InputError: that cannot be done; names the path, what the system says, and a cure.
    """
    try:
        _try(folder)
    except OSError as error:
        raise _cannot_be_written(error, folder) from error


def require_writable_file(file: Path) -> None:
    """Try whether a file can be written, or replaced; afterwards all is as it was.

    Raises:
        InputError: its folder cannot be written, its name cannot be had, or it is there and is no regular file.
    """
    try:
        there = file.exists()  # raises for a name that is too long
        if file.is_dir():
            raise InputError(file, "is a folder", "name a file")
        if there and not file.is_file():
            raise InputError(file, "is no regular file, and would be replaced by one", "name another file")
        _try(file.parent)
    except OSError as error:
        raise _cannot_be_written(error, file) from error


def _try(folder: Path) -> None:
    with _made(folder):
        trial = folder / f".{secrets.token_hex(6)}.tmp"
        try:
            with trial.open("xb") as file:
                file.write(_BLOCK)
        finally:
            trial.unlink(missing_ok=True)


def _cannot_be_written(error: OSError, path: Path) -> InputError:
    told = as_input_error(error)
    return InputError(path, f"cannot be written ({told.problem})", told.cure)


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Make the folder and those above it that are missing; remove them again."""
    missing = []
    for one in (folder, *folder.parents):
        if os.path.lexists(one):
            break
        missing.append(one)
    made: list[Path] = []
    try:
        for one in reversed(missing):
            one.mkdir()
            made.append(one)
        yield
    finally:
        for one in reversed(made):
            one.rmdir()
