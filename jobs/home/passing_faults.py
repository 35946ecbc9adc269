"""Which faults pass by themselves, or once somebody mends a disk, a mount or the store: jobs wait for their end."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from obstore.exceptions import BaseError

__all__ = ["Cause", "PassingFault", "chain", "one_line", "passing_fault"]

LONGEST = 200  # characters of a reason
_TOOK = re.compile(r" in \d[\d.]*[nµm]?s(?= )")  # how long a request took: another time each time

_PASSING = {
    *(errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO),  # the disk
    *(errno.ESTALE, errno.ENOTCONN, errno.ENOLCK),  # a network file system
    *(errno.ETIMEDOUT, errno.EHOSTDOWN, errno.EHOSTUNREACH, errno.ENETDOWN, errno.ENETUNREACH, errno.ENETRESET),
    *(errno.ECONNREFUSED, errno.ECONNRESET, errno.ECONNABORTED),
    *(errno.EMFILE, errno.ENFILE),  # too many open files
}


class Cause(StrEnum):
    """The causes of waiting."""

    HOME = "home"
    DISK = "disk"
    STORE = "store"
    CAPTURE = "capture"


@dataclass(frozen=True)
class PassingFault:
    """A fault of the store, a disk or a mount, in one line."""

    reason: str
    cause: Cause | None = None  # None: a disk or a mount, unknown which


def passing_fault(error: BaseException) -> PassingFault | None:
    """Return the fault of the store, a disk or a mount that made a stage fail; None if it was none of these.

    Looks also at what the error was raised from, or while: libraries replace the system's errors by their own.
    """
    for cause in chain(error):
        if isinstance(cause, BaseError):
            return PassingFault(f"the store fails: {one_line(_TOOK.sub('', str(cause)))}", Cause.STORE)
        if isinstance(cause, OSError) and cause.errno in _PASSING:
            where = f"{cause.filename}: " if cause.filename else ""
            return PassingFault(one_line(f"{where}{cause.strerror or os.strerror(cause.errno)}"))
    return None


def one_line(error: object) -> str:
    """Return the beginning of a message, on one line: some go on for pages."""
    line = " ".join(str(error).partition("\n\n")[0].split())
    return line if len(line) <= LONGEST else line[: LONGEST - 2].rstrip() + " …"


def chain(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and the chain of its causes."""
    seen: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in seen:
        seen.add(id(cause))
        yield cause
        cause = cause.__cause__ or cause.__context__
