"""The temporary folders of stages: one for each, the only place beside its run that a stage may write."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["temporary_folder"]

_PREFIX = "hgs-stage-"
_YOUNGEST = 60.0  # seconds; a younger folder may be about to be locked


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """Have an empty folder while the block runs; those that killed workers of this machine left are removed.

    Raises:
        OSError: it cannot be made.
    """
    _remove_left(Path(tempfile.gettempdir()))
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as name, _locked(Path(name)):
        yield Path(name)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder, which ends with this process.

    Raises:
        OSError: another process has it.
    """
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(opened)


def _remove_left(place: Path) -> None:
    for folder in place.glob(f"{_PREFIX}*"):
        with contextlib.suppress(OSError):
            if time.time() - folder.lstat().st_mtime > _YOUNGEST:
                with _locked(folder):
                    shutil.rmtree(folder)
