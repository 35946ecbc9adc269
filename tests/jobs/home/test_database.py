"""The tables: made once, by the first process."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa
from postgres_server import PostgresServer

from jobs.home.database import connection_url, create_engine
from jobs.home.home import Home
from jobs.queue.client import JobClient

OPEN = """
import dataclasses, sys
from pathlib import Path
from jobs.queue.client import JobClient
from jobs.home.home import Home
sys.stdin.read(1)  # all at the same moment
with JobClient(dataclasses.replace(Home.at(Path(sys.argv[1])), database_url=sys.argv[2])) as client:
    print(len(client.list()))
"""


@pytest.fixture
def start() -> Iterator[Callable[[Path, str], subprocess.Popen[bytes]]]:
    processes: list[subprocess.Popen[bytes]] = []

    def start(folder: Path, url: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-c", OPEN, str(folder), url]
        processes.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("_round", range(3))
def test_three_processes_at_once_open_an_empty_postgres(
    server: PostgresServer, tmp_path: Path, start: Callable[[Path, str], subprocess.Popen[bytes]], _round: int
) -> None:
    url = server.new_database()
    processes = [start(tmp_path, url) for _ in range(3)]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write(b"\n")
        process.stdin.flush()
    assert [process.wait(120) for process in processes] == [0, 0, 0]


def test_what_an_interrupted_migration_left_is_healed(server: PostgresServer, tmp_path: Path) -> None:
    url = server.new_database()
    home = dataclasses.replace(Home.at(tmp_path), database_url=url)
    JobClient(home).close()
    name = sa.make_url(url).database
    assert name
    index = "idx_workflow_status_deadline"  # one that DBOS builds concurrently, in its migration 122
    server.execute(name, f"UPDATE pg_index SET indisvalid = false WHERE indexrelid = 'dbos.{index}'::regclass")
    server.execute(name, "UPDATE dbos.dbos_migrations SET version = 121")
    with JobClient(home) as client:
        assert client.list() == []
    valid = server.execute(name, f"SELECT indisvalid FROM pg_index WHERE indexrelid = 'dbos.{index}'::regclass")
    assert [tuple(row) for row in valid] == [(True,)]


class TestConnectionUrl:
    def url(self, url: str) -> sa.URL:
        return connection_url(Home(Path("/home"), url, "file:///store"))

    def test_both_ends_of_a_postgres_connection_are_tested(self) -> None:
        query = self.url("postgresql://hgs:secret@db/hgs").query
        assert query["keepalives_idle"] == "5"
        assert "-c tcp_keepalives_idle=5" in query["options"]
        assert "-c tcp_user_timeout=10000" in query["options"]

    def test_what_the_user_says_comes_last_and_stays(self) -> None:
        query = self.url(
            "postgresql://db/hgs?options=-c%20tcp_keepalives_idle%3D60&keepalives_idle=9&sslmode=require"
        ).query
        assert (query["keepalives_idle"], query["sslmode"]) == ("9", "require")
        assert str(query["options"]).endswith(" -c tcp_keepalives_idle=60")

    def test_sqlite_needs_nothing(self) -> None:
        assert str(self.url("sqlite:////home/jobs.sqlite")) == "sqlite:////home/jobs.sqlite"

    def test_the_server_believes_it(self, tmp_path: Path, tcp_server: PostgresServer) -> None:
        home = Home(tmp_path, tcp_server.new_database(), "file:///store")
        engine = create_engine(home)
        with engine.connect() as connection:
            query = "SELECT name, setting FROM pg_settings WHERE name IN ('tcp_keepalives_idle', 'tcp_user_timeout')"
            settings = {row.name: row.setting for row in connection.exec_driver_sql(query)}
        engine.dispose()
        assert settings == {"tcp_keepalives_idle": "5", "tcp_user_timeout": "10000"}
