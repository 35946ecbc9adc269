from __future__ import annotations

import os
import time

import pytest
import sqlalchemy as sa

from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.records.job_schema import worker_rows
from jobs.records.worker_register import WorkerRegister, list_workers, main


def test_a_worker_tells_what_it_does(engine: sa.Engine) -> None:
    register = WorkerRegister(engine, "here-1")
    register.tell("", "starting")
    register.tell("studio-1", "")
    (found,) = list_workers(engine)
    assert (found.id, found.pid, found.job_id, found.idle_because) == ("here-1", os.getpid(), "studio-1", "")


def test_nothing_new_is_not_written_at_every_look(engine: sa.Engine) -> None:
    register = WorkerRegister(engine, "here-1")
    register.tell("a", "")
    (before,) = list_workers(engine)
    register.tell("a", "")
    assert list_workers(engine) == [before]


def test_a_worker_that_was_stopped_is_gone_at_once(engine: sa.Engine) -> None:
    register = WorkerRegister(engine, "here-1")
    register.tell("", "")
    register.leave()
    assert list_workers(engine) == []


def test_the_health_check_asks_for_a_worker_on_this_host(home: Home, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in home.environment().items():
        monkeypatch.setenv(name, value)
    with JobClient(home) as client:
        WorkerRegister(client._engine, "here").tell("", "")
        main()
        with client._engine.begin() as connection:
            connection.execute(sa.update(worker_rows).values(host="another"))
        with pytest.raises(SystemExit, match="has spoken"):
            main()


def test_one_that_died_is_not_listed_a_minute_later(engine: sa.Engine) -> None:
    WorkerRegister(engine, "dead").tell("a", "")
    with engine.begin() as connection:
        connection.execute(sa.update(worker_rows).values(seen=time.time() - 61))
    WorkerRegister(engine, "here").tell("", "")
    assert [one.id for one in list_workers(engine)] == ["here"]
