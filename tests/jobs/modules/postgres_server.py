"""A real Postgres server of a test's own, where its programs are installed."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

import sqlalchemy as sa


def missing_program() -> str:
    """Return why no server can be started here; "" if one can."""
    missing = [name for name in ("initdb", "postgres") if program(name) is None]
    return f"no {' and no '.join(missing)} on PATH or in /usr/lib/postgresql: install PostgreSQL" if missing else ""


def program(name: str) -> str | None:
    """Return where a program of Postgres is: on PATH, or where Debian keeps those of the newest version."""
    folders = Path("/usr/lib/postgresql").glob("*/bin")
    newest = sorted(folders, key=lambda folder: float(folder.parent.name), reverse=True)
    return shutil.which(name) or next((found for folder in newest if (found := shutil.which(name, path=folder))), None)


class PostgresServer:
    """A Postgres server on a Unix socket and, if an address is given, on a free TCP port of it.

    It runs as a user that may run it, believes everybody who connects, and keeps its files in `folder`.
    """

    def __init__(self, folder: Path, address: str = "") -> None:
        self._folder = folder
        self._address = address
        self.port = free_port(address) if address else 5432
        self._user = "nobody" if os.geteuid() == 0 else None
        if self._user:
            shutil.chown(folder, self._user)
        data = folder / "data"
        initdb = [str(program("initdb")), "--no-sync", "--auth=trust", "--username=hgs", f"--pgdata={data}"]
        subprocess.run(initdb, check=True, user=self._user, cwd=folder, stdout=subprocess.DEVNULL)
        with (data / "pg_hba.conf").open("a") as rules:
            rules.write("host all all all trust\n")
        self._process: subprocess.Popen[bytes] | None = None
        self._databases = 0

    def start(self) -> None:
        options = {"listen_addresses": self._address, "port": str(self.port), "fsync": "off"}
        command = [str(program("postgres")), "-D", str(self._folder / "data"), "-k", str(self._folder)]
        for name, value in options.items():
            command += ["-c", f"{name}={value}"]
        with (self._folder / "server.log").open("ab") as log:
            self._process = subprocess.Popen(command, user=self._user, cwd=self._folder, stdout=log, stderr=log)
        deadline = time.monotonic() + 60
        while not self._answers():
            assert self._process.poll() is None, "the server ended"
            assert time.monotonic() < deadline, "the server does not answer"
            time.sleep(0.05)

    def stop(self) -> None:
        """Drop all connections and end."""
        if self._process is not None:
            self._process.send_signal(signal.SIGINT)  # "fast" shutdown
            self._process.wait(60)
            self._process = None

    def url(self, database: str) -> str:
        """Return the URL of a database, by TCP if the server has an address."""
        return f"postgresql://hgs@/{database}?host={self._address or self._folder}&port={self.port}"

    def new_database(self, name: str = "") -> str:
        """Create an empty database and return its URL."""
        self._databases += 1
        name = name or f"test_{self._databases}"
        self.execute("postgres", f"CREATE DATABASE {name}")
        return self.url(name)

    def execute(self, database: str, statement: str) -> list[sa.Row[tuple[object, ...]]]:
        """Run one statement outside a transaction and return its rows."""
        url = sa.make_url(self.url(database)).set(drivername="postgresql+psycopg")
        engine = sa.create_engine(url, isolation_level="AUTOCOMMIT", poolclass=sa.NullPool)
        with engine.connect() as connection:
            result = connection.exec_driver_sql(statement)
            return list(result) if result.returns_rows else []

    def _answers(self) -> bool:
        try:
            self.execute("postgres", "SELECT 1")
        except sa.exc.OperationalError:
            return False
        return True


def free_port(address: str) -> int:
    """Return a port of an address that nobody has."""
    with socket.socket() as probe:
        probe.bind((address, 0))
        port: int = probe.getsockname()[1]
        return port
