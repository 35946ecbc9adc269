"""The exclusion of publishing and collecting: a publisher does not store a chunk again that is there already.

The lock is a file where all processes share a folder, and an advisory lock of Postgres where they do not.
"""

from __future__ import annotations

import errno
import fcntl
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from hgs_core.base.errors import InputError

__all__ = ["FileStoreLock", "PostgresStoreLock", "StoreLock"]

_POLL = 0.2  # seconds
_KEY = 0x484753_53  # any constant: the advisory lock


class StoreLock(ABC):
    """Many publish at once, or one collects."""

    @contextmanager
    def publishing(self, waiting: Callable[[], object]) -> Iterator[Callable[[], object]]:
        """Keep collectors out; `waiting` is called again and again while one is at work.

        Yields what raises an error if the lock was lost since: to be called before the manifest is written.
        """
        with self._held(waiting, alone=False) as require:
            yield require

    @contextmanager
    def collecting(self, patience: float) -> Iterator[None]:
        """Keep publishers and other collectors out.

        Raises:
            InputError: scenes have been published for the `patience`, in seconds, without a pause.
        """
        deadline = time.monotonic() + patience

        def wait() -> None:
            if time.monotonic() >= deadline:
                raise InputError("the store", "a scene is being published, or collected", "try again later")

        with self._held(wait, alone=True):
            yield

    @abstractmethod
    def _held(self, waiting: Callable[[], object], *, alone: bool) -> AbstractContextManager[Callable[[], object]]: ...


class FileStoreLock(StoreLock):
    """A file lock, which the kernel drops with the process, however that ends."""

    def __init__(self, path: Path) -> None:
        """Lock `path`, which is made where it is missing."""
        self._path = path

    @contextmanager
    def _held(self, waiting: Callable[[], object], *, alone: bool) -> Iterator[Callable[[], object]]:
        kind = fcntl.LOCK_EX if alone else fcntl.LOCK_SH
        self._path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            while True:
                try:
                    fcntl.flock(file, kind | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    waiting()
                    time.sleep(_POLL)
            yield lambda: None
        finally:
            os.close(file)


class PostgresStoreLock(StoreLock):
    """An advisory lock on a connection of its own; the server drops it with the connection."""

    def __init__(self, url: sa.URL) -> None:
        """Prepare to connect to `url` (`jobs.home.database.connection_url`)."""
        self._url = url

    @contextmanager
    def _held(self, waiting: Callable[[], object], *, alone: bool) -> Iterator[Callable[[], object]]:
        take = sa.func.pg_try_advisory_lock if alone else sa.func.pg_try_advisory_lock_shared
        engine = sa.create_engine(
            self._url, poolclass=sa.NullPool, isolation_level="AUTOCOMMIT", connect_args={"connect_timeout": 10}
        )

        def ask(session: sa.Connection, question: sa.ColumnElement[Any]) -> Any:
            try:
                return session.execute(sa.select(question)).scalar_one()
            except sa.exc.DBAPIError as error:
                raise _away() from error

        with _connected(
            engine
        ) as session:  # tried again and again: see `jobs.home.database`, where one migrates at a time
            while not ask(session, take(_KEY)):
                waiting()
                time.sleep(_POLL)
            yield lambda: ask(session, sa.literal(1))


@contextmanager
def _connected(engine: sa.Engine) -> Iterator[sa.Connection]:
    try:
        session = engine.connect()
    except sa.exc.DBAPIError as error:
        raise _away() from error
    with session:
        yield session


def _away() -> OSError:
    """Return a broken connection as a passing fault."""
    return OSError(errno.ECONNRESET, os.strerror(errno.ECONNRESET), "the job database")
