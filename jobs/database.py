"""The database that holds the job table and the tables of DBOS: SQLite by default, Postgres across machines."""

from __future__ import annotations

import fcntl
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sqlalchemy as sa
from dbos import DBOSClient, DBOSPortableJSONSerializer, run_dbos_database_migrations

from jobs.home import Home

__all__ = ["APPLICATION", "create_engine", "open_client", "prepare_database"]

APPLICATION = "hgs"
BUSY_TIMEOUT = 30_000  # milliseconds that a SQLite writer waits for another
MIGRATION_LOCK = 0x484753  # any constant: the Postgres advisory lock that lets one process migrate at a time


def create_engine(home: Home) -> sa.Engine:
    """Return an engine for the home's database; nothing connects yet.

    On SQLite every transaction that writes takes the write lock when it begins, so that two writers queue up instead of
    failing half-way, and waits for it up to 30 s.
    """
    url = sa.make_url(home.database_url)
    if url.get_backend_name() != "sqlite":
        return sa.create_engine(
            url.set(drivername="postgresql+psycopg"), pool_pre_ping=True, connect_args={"connect_timeout": 10}
        )
    engine = sa.create_engine(url)

    @sa.event.listens_for(engine, "connect")
    def configure(connection: Any, record: Any) -> None:
        connection.isolation_level = "IMMEDIATE"
        connection.execute(f"PRAGMA busy_timeout={BUSY_TIMEOUT}")
        connection.execute("PRAGMA foreign_keys=ON")

    return engine


def prepare_database(home: Home, engine: sa.Engine, metadata: sa.MetaData) -> None:
    """Create or migrate all tables; safe to call from several processes at once.

    On SQLite this also switches the file to write-ahead logging, which the file then remembers: readers no longer wait
    for writers.
    """
    logging.getLogger("dbos").setLevel(logging.WARNING)
    home.runs.mkdir(parents=True, exist_ok=True)
    with _one_at_a_time(home, engine):
        if engine.dialect.name == "sqlite":
            with engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA journal_mode=WAL")
        run_dbos_database_migrations(home.database_url)
        metadata.create_all(engine)


def open_client(home: Home, engine: sa.Engine) -> DBOSClient:
    """Return a client that enqueues and cancels workflows without running any."""
    return DBOSClient(
        system_database_url=home.database_url,
        system_database_engine=engine if engine.dialect.name == "sqlite" else None,
        serializer=DBOSPortableJSONSerializer(),
        application_name=APPLICATION,
        retry_connection_errors=False,  # an unreachable database is an error to report, not a reason to hang
    )


@contextmanager
def _one_at_a_time(home: Home, engine: sa.Engine) -> Iterator[None]:
    """Let one process migrate at a time: a file lock beside SQLite, an advisory lock in Postgres."""
    if engine.dialect.name == "sqlite":
        with (home.folder / "migration.lock").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
        return
    # Without an open transaction: a migration that builds an index concurrently would wait for its end, for ever.
    with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        connection.execute(sa.select(sa.func.pg_advisory_lock(MIGRATION_LOCK)))
        try:
            yield
        finally:
            connection.execute(sa.select(sa.func.pg_advisory_unlock(MIGRATION_LOCK)))
