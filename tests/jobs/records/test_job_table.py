from __future__ import annotations

import time
from pathlib import Path

import pytest
import sqlalchemy as sa

from hgs_core.base.progress import Progress
from jobs.home.database import prepare_database
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.records.job import Job, JobState, Place
from jobs.records.job_table import JobTable, metadata


@pytest.fixture
def table(engine: sa.Engine) -> JobTable:
    table = JobTable(engine)
    with engine.begin() as connection:
        table.insert(connection, Job(id="a", title="A", capture="/captures/a", config={"seed": 0}))
    return table


def state(table: JobTable) -> JobState:
    job = table.get("a")
    assert job is not None
    return job.state


def waiting(table: JobTable) -> str:
    job = table.get("a")
    assert job is not None
    return job.waiting


def test_a_new_job_is_queued(table: JobTable) -> None:
    job = table.get("a")
    assert job is not None
    assert (job.title, job.config, job.state, job.attempt) == ("A", {"seed": 0}, JobState.QUEUED, 1)
    assert job.created == job.updated > 0


def test_an_unknown_job_is_none(table: JobTable) -> None:
    assert table.get("b") is None


def test_the_newest_jobs_come_first(engine: sa.Engine, table: JobTable) -> None:
    with engine.begin() as connection:
        table.insert(connection, Job(id="b", title="B", capture="", config={}))
    assert [job.id for job in table.page(10)] == ["b", "a"]
    assert [job.id for job in table.page(1)] == ["b"]


def add(engine: sa.Engine, table: JobTable, job_id: str, state: JobState) -> None:
    with engine.begin() as connection:
        table.insert(connection, Job(id=job_id, title="", capture="", config={}, state=state))


def test_jobs_are_counted_by_state(engine: sa.Engine, table: JobTable) -> None:
    for name in ("running", "second"):
        add(engine, table, name, JobState.RUNNING)
    assert table.counts() == {"queued": 1, "running": 2, "waiting": 0, "succeeded": 0, "failed": 0, "cancelled": 0}


def test_a_waiting_job_has_those_ahead_that_were_queued_before_it(engine: sa.Engine, table: JobTable) -> None:
    add(engine, table, "running", JobState.RUNNING)
    for job_id in ("b", "c"):
        add(engine, table, job_id, JobState.QUEUED)
    jobs = table.many(["a", "b", "c"])
    assert [table.ahead_of(jobs[job_id]) for job_id in ("a", "b", "c")] == [0, 1, 2]
    table.start("a", 1)
    assert table.ahead_of(jobs["c"]) == 1


def test_a_job_of_higher_priority_is_ahead_however_young(engine: sa.Engine, table: JobTable) -> None:
    with engine.begin() as connection:
        table.insert(connection, Job(id="b", title="", capture="", config={}, priority=1))
    jobs = table.many(["a", "b"])
    assert [table.ahead_of(jobs[job_id]) for job_id in ("a", "b")] == [1, 0]


def test_jobs_that_run_come_first_then_those_that_wait_however_old(engine: sa.Engine, table: JobTable) -> None:
    table.start("a", 1)
    add(engine, table, "b", JobState.QUEUED)
    for number in range(200):
        add(engine, table, f"c{number:03}", JobState.SUCCEEDED)
    add(engine, table, "d", JobState.RUNNING)
    assert [job.id for job in table.page(4)] == ["d", "a", "b", "c199"]
    assert [job.id for job in table.page(4, JobState.SUCCEEDED)] == ["c199", "c198", "c197", "c196"]


def test_pages_together_are_all_jobs_once(engine: sa.Engine, table: JobTable, monkeypatch: pytest.MonkeyPatch) -> None:
    states = list(JobState)
    for number in range(23):
        monkeypatch.setattr("time.time", lambda now=number // 3: float(now))  # some at the same moment
        add(engine, table, f"b{number:02}", states[number % len(states)])
    whole = table.page(100)
    pages: list[Job] = []
    while page := table.page(5, after=Place.of(pages[-1]) if pages else None):
        pages += page
    assert pages == whole
    assert len({job.id for job in pages}) == 24
    assert [Place.of(job).turn for job in pages] == sorted(Place.of(job).turn for job in pages)


def test_many_jobs_are_one_query(engine: sa.Engine, table: JobTable) -> None:
    for number in range(300):
        add(engine, table, f"b{number}", JobState.QUEUED)
    statements: list[str] = []
    sa.event.listen(engine, "before_cursor_execute", lambda *arguments: statements.append(arguments[2]))
    found = table.many({f"b{number}" for number in range(300)} | {"nobody"})
    assert sorted(found) == sorted(f"b{number}" for number in range(300))
    assert table.many(set()) == {}
    assert len(statements) == 1


def test_jobs_in_any_number_can_be_asked_for(engine: sa.Engine, table: JobTable) -> None:
    assert list(table.many([*(f"nobody-{number}" for number in range(35_000)), "a"])) == ["a"]


def test_every_worker_that_takes_a_job_has_an_epoch_of_its_own(engine: sa.Engine, table: JobTable) -> None:
    assert [table.start("a", 1), table.start("a", 1)] == [1, 2]
    table.fail("a", 1, "an error")
    assert table.start("a", 1) == 0
    with engine.begin() as connection:
        table.requeue(connection, "a", 1)
    assert table.start("a", 2) == 3


def test_progress_is_kept_with_its_figures(table: JobTable) -> None:
    assert table.start("a", 1)
    assert table.progress("a", 1, Progress("train", 3, 10, {"psnr": 26.5}))
    job = table.get("a")
    assert job is not None
    assert (job.stage, job.done, job.total, job.figures) == ("train", 3, 10, {"psnr": 26.5})


@pytest.mark.parametrize("finish", ["succeed", "fail", "cancel"])
def test_a_finished_job_does_not_change(table: JobTable, finish: str) -> None:
    end = {
        "succeed": lambda: table.succeed("a", 1, "scene"),
        "fail": lambda: table.fail("a", 1, "broken"),
        "cancel": lambda: table.cancel("a", 1),
    }
    assert end[finish]()
    before = table.get("a")
    assert before is not None
    assert before.state.finished
    assert not table.start("a", 1)
    assert not table.progress("a", 1, Progress("train", 1, 2))
    assert not any(change() for change in end.values())
    assert table.get("a") == before


def test_a_retry_begins_the_next_attempt_and_silences_the_old_one(engine: sa.Engine, table: JobTable) -> None:
    table.progress("a", 1, Progress("train", 5, 10))
    table.fail("a", 1, "broken")
    with engine.begin() as connection:
        assert table.requeue(connection, "a", 1)
    job = table.get("a")
    assert job is not None
    assert (job.state, job.attempt, job.error, job.stage, job.done) == (JobState.QUEUED, 2, "", "", 0)
    assert not table.fail("a", 1, "late news of the old attempt")
    assert table.succeed("a", 2, "scene")


@pytest.mark.parametrize("finish", [None, "succeed"])
def test_only_failed_and_cancelled_jobs_can_be_queued_again(
    engine: sa.Engine, table: JobTable, finish: str | None
) -> None:
    if finish:
        table.succeed("a", 1, "scene")
    with engine.begin() as connection:
        assert not table.requeue(connection, "a", 1)


def test_an_attempt_that_is_put_off_becomes_the_next_and_keeps_its_progress(engine: sa.Engine, table: JobTable) -> None:
    table.start("a", 1)
    table.progress("a", 1, Progress("publish", 5, 10))
    with engine.begin() as connection:
        assert table.put_off(connection, "a", 1, "the store fails")
        assert not table.put_off(connection, "a", 1, "late news of the old attempt")
    job = table.get("a")
    assert job is not None
    assert (job.state, job.attempt, job.waiting, job.stage, job.done) == (
        JobState.WAITING,
        2,
        "the store fails",
        "publish",
        5,
    )
    assert table.start("a", 2)
    assert not waiting(table)


@pytest.mark.parametrize("finish", ["succeed", "fail", "cancel", "retry"])
def test_a_job_that_does_not_wait_any_more_says_nothing(engine: sa.Engine, table: JobTable, finish: str) -> None:
    with engine.begin() as connection:
        assert table.put_off(connection, "a", 1, "the store fails")
    if finish == "retry":
        table._update("a", 2, state=JobState.CANCELLED)
        with engine.begin() as connection:
            assert table.requeue(connection, "a", 2)
    else:
        {"succeed": table.succeed, "fail": table.fail}.get(finish, lambda *_: table.cancel("a", 2))("a", 2, "b")
    assert not waiting(table)


def test_jobs_that_wait_for_what_can_be_looked_for(engine: sa.Engine, table: JobTable) -> None:
    add(engine, table, "b", JobState.RUNNING)
    with engine.begin() as connection:
        assert table.put_off(connection, "a", 1, "the capture cannot be reached", Cause.CAPTURE)
        assert table.put_off(connection, "b", 1, "the store fails")
    (waits,) = table.waiting()
    assert (waits.id, waits.cause) == ("a", "capture")
    assert table.wake(waits)
    assert (state(table), waiting(table)) == (JobState.QUEUED, "")
    assert table.waiting() == []


def test_a_job_that_has_begun_is_not_woken(engine: sa.Engine, table: JobTable) -> None:
    with engine.begin() as connection:
        table.put_off(connection, "a", 1, "the capture cannot be reached", Cause.CAPTURE)
    (waits,) = table.waiting()
    table.start("a", 2)
    assert not table.wake(waits)
    assert state(table) is JobState.RUNNING


def test_an_attempt_is_put_back_unless_somebody_has_begun_it_anew(table: JobTable) -> None:
    table.start("a", 1)
    before = table.get("a")
    assert before is not None
    assert table.put_back(before, "its worker died")
    assert (state(table), waiting(table)) == (JobState.QUEUED, "its worker died")
    table.start("a", 1)
    assert not table.put_back(before, "its worker died")
    assert (state(table), waiting(table)) == (JobState.RUNNING, "")


def test_a_running_job_that_nobody_speaks_of_says_so(table: JobTable, monkeypatch: pytest.MonkeyPatch) -> None:
    table.start("a", 1)
    began = time.time()
    monkeypatch.setattr(time, "time", lambda: began + 59)
    assert waiting(table) == ""
    monkeypatch.setattr(time, "time", lambda: began + 300)
    assert waiting(table) == "no worker has reported on it for 5 min"
    table.keep_alive("a", 1)
    assert (state(table), waiting(table)) == (JobState.RUNNING, "")


def test_active_jobs_are_the_unfinished_ones(table: JobTable) -> None:
    assert [job.id for job in table.active()] == ["a"]
    table.cancel("a", 1)
    assert table.active() == []


def test_preparing_twice_keeps_what_is_there(tmp_path: Path, engine: sa.Engine, table: JobTable) -> None:
    prepare_database(Home.at(tmp_path), engine, metadata)
    assert state(table) is JobState.QUEUED


def test_sqlite_logs_ahead_and_waits_for_other_writers(engine: sa.Engine) -> None:
    with engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA busy_timeout").scalar() == 30_000
