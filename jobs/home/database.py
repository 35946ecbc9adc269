"""The database that holds the job table and the tables of DBOS: SQLite by default, Postgres across machines."""

from __future__ import annotations

import fcntl
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sqlalchemy as sa
from dbos import DBOSClient, DBOSPortableJSONSerializer, run_dbos_database_migrations

from jobs.home.home import Home
from jobs.home.home_identity import HomeIdentity, identify_home
from jobs.home.schema_number import note_schema, require_known_schema
from jobs.home.table_upgrades import add_what_is_missing, rename_columns

__all__ = ["APPLICATION", "connection_url", "create_engine", "dbos_url", "open_client", "prepare_database"]

APPLICATION = "hgs"
BUSY_TIMEOUT = 30_000  # milliseconds that a SQLite writer waits for another
MIGRATION_LOCK = 0x484753  # any constant: the Postgres advisory lock that lets one process migrate at a time
MIGRATION_POLL = 0.2  # seconds between two tries to take it

# How soon either end of a Postgres connection notices that the other vanished without a word (a power cut, a pulled
# cable): after 5 + 3 * 2 s of silence, or when 10 s have passed and what was sent is not acknowledged. The system's own
# defaults are two hours and a quarter of an hour; as long the server would hold the locks of a machine that is gone.
KEEPALIVES = {"keepalives_idle": "5", "keepalives_interval": "2", "keepalives_count": "3", "tcp_user_timeout": "10000"}


def connection_url(home: Home) -> sa.URL:
    """Return the URL that every connection to the home's database uses.

    For Postgres it asks the server and the system here to test idle connections every few seconds, and the server to
    end sessions that stand still for a minute inside a transaction, with their locks. What the user's URL
    says of these settings, as parameters or in `options`, stays as it is.
    """
    url = sa.make_url(home.database_url)
    if url.get_backend_name() == "sqlite":
        return url
    on_server = [f"-c {name if name.startswith('tcp_') else 'tcp_' + name}={KEEPALIVES[name]}" for name in KEEPALIVES]
    on_server.append("-c idle_in_transaction_session_timeout=60000")
    own = url.query.get("options", ())
    options = " ".join([*on_server, *((own,) if isinstance(own, str) else own)])  # the last word counts
    query = {**KEEPALIVES, **url.query, "options": options}
    return url.set(drivername="postgresql+psycopg", query=query)


def dbos_url(home: Home) -> str:
    """Return `connection_url` as DBOS takes it."""
    return connection_url(home).render_as_string(hide_password=False)


def create_engine(home: Home, most: int = 15) -> sa.Engine:
    """Return an engine for the home's database, with at most so many connections to a server; nothing connects yet.

    On SQLite every transaction that writes takes the write lock when it begins, so that two writers queue up instead of
    failing half-way, and waits for it up to 30 s.
    """
    url = connection_url(home)
    if url.get_backend_name() != "sqlite":
        # The pool keeps five, or all if they are fewer; the rest comes and goes.
        size = min(most, 5)
        return sa.create_engine(
            url, pool_pre_ping=True, pool_size=size, max_overflow=most - size, connect_args={"connect_timeout": 10}
        )
    engine = sa.create_engine(url)

    @sa.event.listens_for(engine, "connect")
    def configure(connection: Any, record: Any) -> None:
        connection.isolation_level = "IMMEDIATE"
        connection.execute(f"PRAGMA busy_timeout={BUSY_TIMEOUT}")
        connection.execute("PRAGMA foreign_keys=ON")

    return engine


def prepare_database(home: Home, engine: sa.Engine, metadata: sa.MetaData) -> HomeIdentity:
    """Create or upgrade all tables and check the home; safe to call from several processes at once.

    On SQLite this also switches the file to write-ahead logging, which the file then remembers: readers no longer wait
    for writers.

    Raises:
        InputError: the home's folder is not the one that this database belongs to, or later software has changed the
            tables.
    """
    logging.getLogger("dbos").setLevel(logging.WARNING)
    if engine.dialect.name == "sqlite":
        home.folder.mkdir(parents=True, exist_ok=True)
    with _one_at_a_time(home, engine):
        if engine.dialect.name == "sqlite":
            with engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA journal_mode=WAL")
        require_known_schema(home, engine)
        run_dbos_database_migrations(dbos_url(home))
        rename_columns(engine)
        metadata.create_all(engine)
        add_what_is_missing(engine, metadata)
        note_schema(engine)
        identity = identify_home(home, engine)
    home.runs.mkdir(parents=True, exist_ok=True)
    return identity


def open_client(home: Home, engine: sa.Engine) -> DBOSClient:
    """Return a client that enqueues and cancels workflows without running any."""
    return DBOSClient(
        system_database_url=dbos_url(home),
        system_database_engine=engine,
        use_listen_notify=False,  # nothing here waits for events
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
    # Tries in a loop and without an open transaction: a statement that waits for the lock, like a transaction, holds a
    # snapshot, and a migration that builds an index concurrently waits for the end of all snapshots, for ever.
    with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        while not connection.execute(sa.select(sa.func.pg_try_advisory_lock(MIGRATION_LOCK))).scalar_one():
            time.sleep(MIGRATION_POLL)
        try:
            yield
        finally:
            connection.execute(sa.select(sa.func.pg_advisory_unlock(MIGRATION_LOCK)))
