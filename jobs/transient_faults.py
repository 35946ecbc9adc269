"""Which faults pass by themselves, or once somebody mends a disk, a mount or the store: jobs wait for their end."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from obstore.exceptions import BaseError

from jobs.home_identity import HomeIdentity

__all__ = ["one_line", "reason_to_wait", "unreachable"]

LONGEST = 200  # characters of a reason
# Bytes left on a disk that counts as full: libraries hide the error, and remove what they could not write.
FULL = 1 << 20

_PASSING = {
    *(errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO),  # the disk
    *(errno.ESTALE, errno.ENOTCONN, errno.ENOLCK),  # a network file system
    *(errno.ETIMEDOUT, errno.EHOSTDOWN, errno.EHOSTUNREACH, errno.ENETDOWN, errno.ENETUNREACH, errno.ENETRESET),
    *(errno.ECONNREFUSED, errno.ECONNRESET, errno.ECONNABORTED),
    *(errno.EMFILE, errno.ENFILE),  # too many open files
}


def reason_to_wait(error: BaseException) -> str:
    """Return in one line which fault of the store, a disk or a mount made a stage fail; "" if it was none of these.

    Looks also at what the error was raised from, or while: libraries replace the system's errors by their own.
    """
    for cause in _chain(error):
        if isinstance(cause, BaseError):
            return f"the store fails: {one_line(cause)}"
        if isinstance(cause, OSError) and cause.errno in _PASSING:
            where = f"{cause.filename}: " if cause.filename else ""
            return one_line(f"{where}{os.strerror(cause.errno)}")
    return ""


def unreachable(home: HomeIdentity, capture: Path) -> str:
    """Return in one line what a stage needs that this machine does not see now; "" if nothing is missing.

    Asked after a stage has failed, and before that failure is believed.
    """
    mismatch = home.mismatch()
    if mismatch is not None:
        return one_line(mismatch)
    try:
        if shutil.disk_usage(home.folder).free < FULL:
            return f"{home.folder}: {os.strerror(errno.ENOSPC)}"
        if capture.is_dir() and not any(capture.iterdir()):
            return f"{capture}: the capture's folder is empty; is it mounted?"
        capture.stat()
    except OSError as error:
        return f"{capture}: the capture cannot be reached ({error.strerror})"
    return ""


def one_line(error: object) -> str:
    """Return the beginning of a message, on one line: some go on for pages."""
    line = " ".join(str(error).partition("\n\n")[0].split())
    return line if len(line) <= LONGEST else line[: LONGEST - 2].rstrip() + " …"


def _chain(error: BaseException) -> Iterator[BaseException]:
    seen: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in seen:
        seen.add(id(cause))
        yield cause
        cause = cause.__cause__ or cause.__context__
