from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from postgres_server import PostgresServer

from hgs_core.base.errors import InputError
from jobs.artifacts.publishing_lock import FileStoreLock, PostgresStoreLock
from jobs.home.database import connection_url
from jobs.home.home import Home
from jobs.home.passing_faults import PassingFault, passing_fault


class Waited(Exception):  # noqa: N818
    pass


def refuse() -> None:
    raise Waited


def test_publishers_do_not_wait_for_each_other(tmp_path: Path) -> None:
    lock = FileStoreLock(tmp_path / "store" / "lock")
    with lock.publishing(refuse), lock.publishing(refuse):
        pass


def test_a_publisher_waits_for_a_collector(tmp_path: Path) -> None:
    lock = FileStoreLock(tmp_path / "lock")
    with lock.collecting(0), pytest.raises(Waited), lock.publishing(refuse):
        pass
    with lock.publishing(refuse):
        pass


@pytest.mark.parametrize("other", ["publishing", "collecting"])
def test_a_collector_waits_for_everybody_but_not_for_ever(tmp_path: Path, other: str) -> None:
    lock = FileStoreLock(tmp_path / "lock")
    held = lock.publishing(refuse) if other == "publishing" else lock.collecting(0)
    with held, pytest.raises(InputError, match="try again later"), lock.collecting(0.0):
        pass


class TestWithoutASharedFolder:
    @pytest.fixture
    def lock(self, server: PostgresServer, tmp_path: Path) -> PostgresStoreLock:
        home = dataclasses.replace(Home.at(tmp_path), database_url=server.new_database())
        return PostgresStoreLock(connection_url(home))

    def test_many_publish_or_one_collects(self, lock: PostgresStoreLock) -> None:
        with lock.publishing(refuse) as require, lock.publishing(refuse):
            require()
            with pytest.raises(InputError, match="try again later"), lock.collecting(0.0):
                pass
        with lock.collecting(0), pytest.raises(Waited), lock.publishing(refuse):
            pass

    def test_a_publisher_that_lost_the_lock_is_told_before_its_manifest(
        self, lock: PostgresStoreLock, server: PostgresServer
    ) -> None:
        with lock.publishing(refuse) as require:
            server.execute(
                "postgres",
                "SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory'",
            )
            with pytest.raises(OSError, match="the job database") as caught:
                require()
        assert passing_fault(caught.value) == PassingFault("the job database: Connection reset by peer")
