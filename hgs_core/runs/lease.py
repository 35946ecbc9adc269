"""A run's lease: one process at a time works on a run, also where file locks do not reach from one machine to another.

Each holder has a number of its own, the epoch: the file `run.lease.<epoch>`, which only one process can create. It
renews the file's date every two seconds and removes the file at the end. Who finds a lease whose holder is dead, or has
been silent for 20 s, makes the next one and removes the old; a holder whose file is gone has lost the run.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["LeaseHeldError", "lease"]

BEAT = 2.0  # seconds between two signs of life
HOLDER_SILENCE = 20.0  # seconds without one after which a holder on another machine counts as dead

_NAME = "run.lease."


class LeaseHeldError(Exception):
    """Another process holds the run; the message says which."""


@contextmanager
def lease(folder: Path, clock: int, on_lost: Callable[[], object]) -> Iterator[None]:
    """Hold the lease of a run.

    Args:
        folder: of the run.
        clock: a file in it, open for writing: the dates of leases are compared with the file server's time.
        on_lost: called from a thread, once, if another process has taken the lease.

    Raises:
        LeaseHeldError: another process holds it.
        OSError: the folder cannot be written.
    """
    path = _take(folder, clock)
    file = os.open(path, os.O_RDWR)
    over = threading.Event()

    def beat() -> None:
        while not over.wait(BEAT):
            if not _renewed(file):
                if not over.is_set():
                    on_lost()
                return

    threading.Thread(target=beat, name="lease", daemon=True).start()
    try:
        yield
    finally:
        over.set()
        path.unlink(missing_ok=True)
        os.close(file)


def _take(folder: Path, clock: int) -> Path:
    others = _leases(folder)
    os.utime(clock)
    if others:
        _require_dead(others[-1], os.fstat(clock).st_mtime)
    path = folder / f"{_NAME}{_epoch(others[-1]) + 1 if others else 1}"
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError:
        raise LeaseHeldError("another process has just begun to work on it") from None
    try:
        os.write(file, f"{_machine()} {os.getpid()} {_start(os.getpid())}".encode())
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        # A full disk takes no words, and the date alone will do: what frees it may need the lease, too.
    finally:
        os.close(file)
    if _leases(folder)[-1:] != [path]:  # this process was slow: others have come and gone, and the newest counts
        path.unlink(missing_ok=True)
        raise LeaseHeldError("another process has just begun to work on it")
    for other in others:
        other.unlink(missing_ok=True)
    return path


def _require_dead(path: Path, now: float) -> None:
    """Raise a LeaseHeldError if the holder lives; `now` is the file server's."""
    try:
        with path.open() as file:  # opening asks the file server anew
            words, date = file.read().split(), os.fstat(file.fileno()).st_mtime
    except FileNotFoundError:
        return
    if len(words) == 3 and words[0] == _machine() and words[1].isdecimal():
        if _start(int(words[1])) == words[2] != "":
            raise LeaseHeldError(f"process {words[1]} works on it")
    elif abs(now - date) < HOLDER_SILENCE:
        raise LeaseHeldError("a process of another machine works on it")


def _renewed(file: int) -> bool:
    """Renew the date of a lease; return False if it is gone."""
    try:
        os.utime(file)
        return os.fstat(file).st_nlink > 0
    except OSError as error:  # other faults pass, or silence the holder until it counts as dead
        return error.errno != errno.ESTALE


def _leases(folder: Path) -> list[Path]:
    found = (path for path in folder.iterdir() if path.name.startswith(_NAME) and path.suffix[1:].isdecimal())
    return sorted(found, key=_epoch)


def _epoch(path: Path) -> int:
    return int(path.suffix[1:])


def _machine() -> str:
    """Return a mark shared only by processes that see each other by their ids."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{boot}/{Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        return f"{uuid.getnode():x}"


def _start(pid: int) -> str:
    """Return when a process started, in the system's terms; "" if there is none, or only its exit status is left."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return "" if words[0] in "ZX" else words[19]
    except OSError:
        if Path("/proc/self/stat").exists():
            return ""
    with contextlib.suppress(ProcessLookupError):  # no such file system here: the same id must do
        os.kill(pid, 0)
        return "0"
    return ""
