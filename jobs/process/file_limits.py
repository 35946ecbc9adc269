"""How many files a stage may have open and how long one may get, and whether it met these limits."""

from __future__ import annotations

import errno
import os
import re
import resource

from jobs.home.passing_faults import chain

__all__ = ["limit_files", "met_file_limit"]

_NO_CORE = 1  # byte: no file is that short, and of 0 a program that is piped to (core_pattern) is not told


def limit_files(open_at_once: int, longest: float) -> None:
    """Let this process and those that it starts each have so many files open and write none beyond so many bytes.

    They leave no core dumps either, which would hold what the process knew, on the disk of the runs. Limits of the
    system that are lower stay.
    """
    for kind, most in ((resource.RLIMIT_NOFILE, open_at_once), (resource.RLIMIT_FSIZE, int(longest))):
        hard = resource.getrlimit(kind)[1]
        limit = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (_NO_CORE, _NO_CORE))


def met_file_limit(error: BaseException) -> str:
    """Return in one line which limit made a stage fail, and the cure; "" if it was none.

    Libraries may hide that a file could not be opened: then it counts that none can be opened now.
    """
    causes = list(chain(error))
    if _says(causes, errno.EFBIG):
        most = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
        return f"a file too large: limit {most} bytes; raise HGS_STAGE_FILE_SIZE (or ulimit -f) if it is meant"
    if _says(causes, errno.EMFILE) or not _can_open():
        most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        return f"too many open files: limit {most}; raise HGS_STAGE_FILES (or ulimit -n) if they are meant"
    return ""


def _says(causes: list[BaseException], code: int) -> bool:
    # Not "Too many open files in system", which is no limit of this process.
    message = re.compile(re.escape(os.strerror(code)) + "(?! in )")
    return any(getattr(cause, "errno", None) == code or message.search(str(cause)) for cause in causes)


def _can_open() -> bool:
    try:
        os.close(os.dup(0))
    except OSError as error:
        return error.errno != errno.EMFILE
    return True
