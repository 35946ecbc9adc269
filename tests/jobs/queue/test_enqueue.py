"""The queue as DBOS lists it."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
import sqlalchemy as sa
from dbos import DBOSClient, WorkflowStatus

from jobs.home.database import create_engine, open_client, prepare_database
from jobs.home.home import Home
from jobs.queue.enqueue import ask_for_help, enqueue, helper_name, job_of, workflow_id
from jobs.records.job_table import metadata


@pytest.fixture
def engine(home: Home) -> Iterator[sa.Engine]:
    engine = create_engine(home)
    prepare_database(home, engine, metadata)
    yield engine
    engine.dispose()


@pytest.fixture
def queue(home: Home, engine: sa.Engine) -> Iterator[DBOSClient]:
    client = open_client(home, engine)
    yield client
    client.destroy()


def queued(queue: DBOSClient) -> dict[str, WorkflowStatus]:
    return {status.workflow_id: status for status in queue.list_workflows()}


def test_a_higher_priority_is_taken_first_but_not_before_what_was_put_off(engine: sa.Engine, queue: DBOSClient) -> None:
    with engine.begin() as connection:
        for name, priority in (("low", -100), ("plain", 0), ("high", 100)):
            enqueue(queue, connection, name, 1, priority=priority)
        enqueue(queue, connection, "resumed", 2, delay=1)
    by_number = sorted(queued(queue).values(), key=lambda status: status.priority or 0)  # DBOS: the lower is first
    assert [status.workflow_id for status in by_number] == ["resumed:2", "high:1", "plain:1", "low:1"]


def test_a_time_limit_is_the_workflows_timeout(engine: sa.Engine, queue: DBOSClient) -> None:
    with engine.begin() as connection:
        enqueue(queue, connection, "a", 1, time_limit=90.0)
    assert queued(queue)["a:1"].workflow_timeout_ms == 90_000


def test_every_attempt_is_a_workflow_of_its_own(engine: sa.Engine, queue: DBOSClient) -> None:
    with engine.begin() as connection:
        for attempt in (1, 2):
            enqueue(queue, connection, "studio-1a2b", attempt)
    assert sorted(queued(queue)) == ["studio-1a2b:1", "studio-1a2b:2"]
    assert workflow_id("studio-1a2b", 2) == "studio-1a2b:2"


def test_a_new_job_begins_with_the_first_stage_and_may_be_taken_at_once(engine: sa.Engine, queue: DBOSClient) -> None:
    with engine.begin() as connection:
        enqueue(queue, connection, "a", 1)
    status = queued(queue)["a:1"]
    assert (status.queue_name, status.name, status.status) == ("training", "train_job", "ENQUEUED")
    assert status.input is not None
    assert status.input["args"] == ("a", 1, 0, "initialise")


def test_a_job_that_was_put_off_is_taken_later_and_before_new_ones(engine: sa.Engine, queue: DBOSClient) -> None:
    before = time.time()
    with engine.begin() as connection:
        enqueue(queue, connection, "new", 1)
        enqueue(queue, connection, "old", 2, delay=600, waits=3, first="encode")
    found = queued(queue)
    assert found["old:2"].status == "DELAYED"
    assert found["old:2"].delay_until_epoch_ms is not None
    assert found["old:2"].delay_until_epoch_ms / 1000 >= before + 599
    assert found["old:2"].input is not None
    assert found["old:2"].input["args"] == ("old", 2, 3, "encode")
    assert found["old:2"].priority is not None
    assert found["new:1"].priority is not None
    assert found["old:2"].priority < found["new:1"].priority  # DBOS takes the lowest number first


def test_nothing_is_queued_if_the_caller_s_transaction_fails(engine: sa.Engine, queue: DBOSClient) -> None:
    with engine.connect() as connection, connection.begin() as transaction:
        enqueue(queue, connection, "a", 1)
        transaction.rollback()
    assert queued(queue) == {}


def test_help_that_is_asked_for_again_is_there_once_and_stands_behind_no_job_of_its_priority(
    engine: sa.Engine, queue: DBOSClient
) -> None:
    for _ in range(2):  # the worker that asked has died
        with engine.begin() as connection:
            ask_for_help(queue, connection, "studio", 2, 3, priority=5)
    with engine.begin() as connection:
        enqueue(queue, connection, "next", 1, priority=5)
    found = queued(queue)
    assert set(found) == {"studio#1:2", "studio#2:2", "studio#3:2", "next:1"}
    assert len({status.priority for status in found.values()}) == 1


def test_name_of_a_helper_tells_its_job() -> None:
    assert job_of(helper_name("studio", 3)) == job_of("studio") == "studio"
