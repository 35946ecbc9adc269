"""Errors of the system, of files and disks, in one line with a cure."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["THE_OUTPUT", "as_input_error"]

THE_OUTPUT = "the output"
"""The place of an error that names no file: of a write, to standard output as a rule."""

_CURES = {
    errno.ENOSPC: "make room on that disk, or give a place on another",
    errno.EDQUOT: "make room there, or give a place on another disk",
    errno.EFBIG: "raise the limit of files (ulimit -f), or give a place on another disk",
    errno.EROFS: "give a place on a disk that can be written",
    errno.EACCES: "give a place that is yours, or have its owner let you in (ls -ld shows who that is)",
    errno.EPERM: "give a place that is yours, or have its owner let you in (ls -ld shows who that is)",
    errno.ENOTDIR: "a part of the path is a file: give a path through folders alone",
    errno.EEXIST: "a file of this name is in the way: give another path",
    errno.ENAMETOOLONG: "give a shorter name",
    errno.ENOENT: "check the path, letter by letter",
    errno.ENODEV: "give a place on a disk",
    errno.EISDIR: "it is a folder: name a file",
    errno.ELOOP: "a link leads back to itself: give a path without it",
    errno.EMFILE: "raise the limit of open files (ulimit -n)",
    errno.ENOTEMPTY: "give a new folder",
    errno.EIO: "the disk fails: give a place on another",
}


def as_input_error(error: OSError, path: Path | None = None) -> InputError:
    """Return an error of the system as one line: the file, the problem, the cure.

    The file is the one that the error names, or else `path`, or else `THE_OUTPUT`.
    """
    name = error.filename if error.filename is not None else path
    where = THE_OUTPUT if name is None else os.fsdecode(name) if isinstance(name, str | bytes) else str(name)
    problem = error.strerror or str(error) or type(error).__name__
    return InputError(where or "the empty path", problem[:1].lower() + problem[1:], _CURES.get(error.errno or 0, ""))
