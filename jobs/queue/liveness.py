"""Which workers are alive: each holds a lock that the system drops when the worker dies.

On one machine it is a file lock, which the kernel drops with the process. Across machines it is a Postgres advisory
lock, which the server drops with the connection. A worker that cannot prove that it still holds its lock ends itself
before another may take its work over.
"""

from __future__ import annotations

import fcntl
import hashlib
import logging
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import sqlalchemy as sa

from jobs.home.database import connection_url
from jobs.home.home import Home
from jobs.process.lasting_thread import lasting_thread

__all__ = ["FileLiveness", "Liveness", "PostgresLiveness", "open_liveness"]

log = logging.getLogger(__name__)


class Liveness(Protocol):
    """Proof of life of one worker, and the test of others'."""

    def hold(self, executor: str, on_lost: Callable[[], None]) -> None:
        """Be alive as `executor` from now on; `on_lost` is called when that can no longer be proved."""

    def claim_dead(self, executor: str) -> AbstractContextManager[bool]:
        """Return a context that yields whether `executor` is dead; two callers never get True at the same time."""

    def suspects(self, executor: str) -> bool:
        """Return whether `executor` was not alive when it was last looked at, but may yet prove that it is."""


def open_liveness(home: Home) -> Liveness:
    """Return the kind that fits the database."""
    if sa.make_url(home.database_url).get_backend_name() == "sqlite":
        return FileLiveness(home.folder / "live")
    return PostgresLiveness(connection_url(home))


class FileLiveness:
    """One locked file per worker. It cannot be lost while the process lives, so there is nothing to fence."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._folder.mkdir(parents=True, exist_ok=True)

    def hold(self, executor: str, on_lost: Callable[[], None]) -> None:
        """Be alive as `executor` until the process ends."""
        hidden = self._folder / f".{executor}"
        # A bare descriptor: nothing closes it but the end of the process, and no child inherits it.
        fcntl.flock(os.open(hidden, os.O_RDWR | os.O_CREAT), fcntl.LOCK_EX)
        hidden.rename(self._folder / executor)  # it appears locked
        for path in self._folder.iterdir():
            if not path.name.startswith("."):
                with self.claim_dead(path.name):
                    pass  # entering removes the files of the dead

    @contextmanager
    def claim_dead(self, executor: str) -> Iterator[bool]:
        """Yield True if no living process holds the file of `executor`."""
        path = self._folder / executor
        try:
            file = path.open("r+")
        except FileNotFoundError:
            yield True
            return
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                yield False
                return
            yield True
            path.unlink(missing_ok=True)

    def suspects(self, executor: str) -> bool:
        """Return False: the kernel leaves no doubt."""
        return False


class PostgresLiveness:
    """One advisory lock per worker, on a connection of its own that is tried every second.

    If the connection breaks (a restart of the server, a network fault), the worker has `patience` seconds to take the
    lock again before it must end itself; others wait for `grace` seconds before they believe that it is dead. Others
    are looked at on the same connection: one that is shared with what follows from the look could be waited for by
    both for ever.
    """

    def __init__(
        self, url: str | sa.URL, *, patience: float = 20.0, grace: float = 30.0, interval: float = 1.0
    ) -> None:
        """Prepare to connect to `url`, which has short keepalives for both ends (`connection_url`).

        All times in seconds, `patience` well below `grace`.
        """
        self._patience, self._grace, self._interval = patience, grace, interval
        # Without a pool, closing a connection ends its session, and with it all its locks.
        self._engine = sa.create_engine(
            sa.make_url(url).set(drivername="postgresql+psycopg"),
            poolclass=sa.NullPool,
            isolation_level="AUTOCOMMIT",
            connect_args={"connect_timeout": 5},
        )
        self._session: sa.Connection | None = None
        self._holds = False  # the session has our own lock
        self._turn = threading.Lock()  # one user of the session at a time
        self._first_seen_dead: dict[str, float] = {}
        self._last_proof = 0.0
        self._lost = threading.Event()

    def hold(self, executor: str, on_lost: Callable[[], None]) -> None:
        """Be alive as `executor`; `on_lost` is called from a thread once `patience` has run out."""
        if not self._ask(sa.func.pg_try_advisory_lock(_key(executor))):
            raise RuntimeError(f"executor {executor} already exists")
        self._holds, self._last_proof = True, _now()
        lasting_thread("proof of life", partial(self._prove, executor)).start()
        lasting_thread("watch of the proof of life", partial(self._watch, on_lost)).start()

    @contextmanager
    def claim_dead(self, executor: str) -> Iterator[bool]:
        """Yield True if the lock of `executor` has been free for `grace` seconds."""
        if not self._ask(sa.func.pg_try_advisory_lock(_key(executor))):
            self._first_seen_dead.pop(executor, None)
            yield False
            return
        try:
            since = self._first_seen_dead.setdefault(executor, _now())
            if _now() - since >= self._grace:
                yield True
                self._first_seen_dead.pop(executor, None)
                return
        finally:
            with suppress(sa.exc.DBAPIError):  # a broken connection has lost the lock anyway
                self._ask(sa.func.pg_advisory_unlock(_key(executor)))
        # The lock is free again here, so that a worker that only lost its connection can take it.
        yield False

    def suspects(self, executor: str) -> bool:
        """Return whether the lock of `executor` was free when it was last looked at, but not for `grace` seconds."""
        return executor in self._first_seen_dead

    def _ask(self, question: sa.ColumnElement[Any]) -> Any:
        """Return the server's answer on our session, which is opened if needed."""
        with self._turn:
            if self._session is None:
                self._session, self._holds = self._engine.connect(), False
            try:
                return self._session.execute(sa.select(question)).scalar_one()
            except sa.exc.DBAPIError:
                self._session.invalidate()
                self._session.close()
                self._session, self._holds = None, False
                raise

    def _prove(self, executor: str) -> None:
        """Try the session again and again, and take the lock again when it was broken. May hang; `_watch` does not."""
        while not self._lost.wait(self._interval):
            try:
                self._ask(sa.literal(1))
                if not self._holds:
                    self._holds = bool(self._ask(sa.func.pg_try_advisory_lock(_key(executor))))
                if self._holds:
                    self._last_proof = _now()
            except sa.exc.DBAPIError as error:
                log.warning("lost the connection that proves that %s is alive: %s", executor, error.orig)

    def _watch(self, on_lost: Callable[[], None]) -> None:
        while _now() - self._last_proof < self._patience:
            time.sleep(self._interval)
        self._lost.set()
        on_lost()


def _key(executor: str) -> int:
    """Return the number of an executor's advisory lock, a signed 64-bit integer."""
    return int.from_bytes(hashlib.sha256(executor.encode()).digest()[:8], signed=True)


def _now() -> float:
    """Return seconds that also pass while the machine is suspended, where the system has such a clock."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) if hasattr(time, "CLOCK_BOOTTIME") else time.monotonic()
