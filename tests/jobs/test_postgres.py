"""The queue on a real Postgres server, where its programs are installed."""

from __future__ import annotations

import dataclasses
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa
from postgres_server import PostgresServer

from hgs_core.base.progress import Progress
from jobs.home.database import create_engine
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.liveness import PostgresLiveness
from jobs.records.job import Job, JobState, Place
from jobs.records.job_table import JobTable

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]
Poll = Callable[[Callable[[], bool], str], None]


@pytest.fixture
def home(tmp_path: Path, pipeline: str, server: PostgresServer) -> Home:
    local = Home.at(tmp_path / "home")
    return dataclasses.replace(local, pipeline=pipeline, database_url=server.new_database())


def finished(job: Job) -> bool:
    return job.state.finished


def iterations(run: Path) -> list[tuple[int, int]]:
    log = run / "iterations.log"
    lines = log.read_text().splitlines() if log.exists() else []
    return [(int(pid), int(iteration)) for pid, iteration in (line.split() for line in lines)]


@pytest.mark.slow
def test_cancel_and_retry_are_the_same_as_on_sqlite(
    home: Home, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    worker()
    job_id = submit(iterations=150)
    wait_until(lambda: len(iterations(home.run(job_id))) >= 3, "three iterations")
    with JobClient(home) as client:
        assert client.cancel(job_id).state is JobState.CANCELLED
        assert client.retry(job_id).attempt == 2
    assert wait_for(job_id, finished, "the end of the retry").state is JobState.SUCCEEDED
    assert [iteration for _, iteration in iterations(home.run(job_id))] == list(range(150))


@pytest.mark.slow
def test_a_worker_has_three_connections_at_most(
    home: Home, server: PostgresServer, client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker]
) -> None:
    job_id = submit(iterations=100, behaviour="full once")  # it is put off once
    client.close()
    database = sa.make_url(home.database_url).database
    assert database
    worker()
    # All but those that ask, of which the last may still be leaving, and the server's own that tidy tables.
    others = "backend_type = 'client backend' AND strpos(query, 'pg_stat_activity') = 0"
    count = f"SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND {others}"
    state = f"SELECT state, '/* pg_stat_activity */' FROM hgs_job WHERE id = '{job_id}'"
    most = 0
    while server.execute(database, state)[0][0] not in ("succeeded", "failed"):
        most = max(most, server.execute(database, count)[0][0])
    assert most == 3


def test_old_attempts_cannot_write(home: Home, client: object, submit: Callable[..., str]) -> None:
    engine = create_engine(home)
    table = JobTable(engine)
    job_id = submit()
    assert table.start(job_id, 1)
    assert table.progress(job_id, 1, Progress("train", 1, 2, {"psnr": 30.5}))
    assert not table.fail(job_id, 2, "not yet")
    assert table.cancel(job_id, 1)
    with engine.begin() as connection:
        assert table.requeue(connection, job_id, 1)
    assert not table.succeed(job_id, 1, "late")
    engine.dispose()


def test_lists_are_the_same_as_on_sqlite_and_outlast_a_restart(
    server: PostgresServer, home: Home, client: JobClient, submit: Callable[..., str]
) -> None:
    ids = [submit() for _ in range(3)]
    engine = create_engine(home)
    assert JobTable(engine).start(ids[0], 1)
    engine.dispose()
    first = client.list(2)
    assert [job.id for job in first] == [ids[0], ids[2]]
    assert [job.id for job in client.list(2, after=Place.of(first[-1]))] == [ids[1]]
    assert [job.id for job in client.list(2, JobState.QUEUED)] == [ids[2], ids[1]]
    server.stop()
    with pytest.raises(sa.exc.OperationalError):
        client.many(ids)
    server.start()
    assert client.many([*ids, "nobody"]) == {job_id: client.get(job_id) for job_id in ids}


def test_a_restart_of_the_server_costs_no_training(
    server: PostgresServer,
    home: Home,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    wait_until: Poll,
) -> None:
    worker()
    job_id = submit(iterations=150)
    run = home.run(job_id)
    wait_until(lambda: len(iterations(run)) >= 3, "three iterations")
    server.stop()
    server.start()
    job = wait_for(job_id, finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    assert [iteration for _, iteration in iterations(run)] == list(range(150))
    assert len({pid for pid, _ in iterations(run)}) == 1


@pytest.mark.slow
def test_another_worker_takes_over_after_kill_9(
    home: Home, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    job_id = submit(iterations=150)
    run = home.run(job_id)
    first = worker()
    wait_until(lambda: len(iterations(run)) >= 12, "twelve iterations")
    worker()
    first.kill()
    first.wait()
    before = len(iterations(run))
    job = wait_for(job_id, finished, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    after = [iteration for _, iteration in iterations(run)][before:]
    assert after == list(range(after[0], 150))
    assert after[0] in (before - before % 5, before + 1 - (before + 1) % 5)


@pytest.mark.slow
def test_an_interrupted_job_comes_before_younger_ones(
    home: Home, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    job_id, younger = submit(iterations=150), submit(iterations=3)
    first = worker()
    wait_until(lambda: len(iterations(home.run(job_id))) >= 12, "twelve iterations")
    first.kill()
    first.wait()
    worker()  # long before the first can be taken for dead
    waiting = wait_for(job_id, lambda job: job.state is JobState.QUEUED, "the end of the grace")
    assert waiting.waiting == "its worker died; the next free one goes on with it"
    wait_for(younger, lambda job: job.state is not JobState.QUEUED, "the start of the younger job")
    assert wait_for(job_id, lambda job: True, "the first job").state is JobState.SUCCEEDED


@pytest.fixture
def no_proofs_after_the_test(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """End the proofs of life with their test: they would go on, and complain, when the database has gone."""
    holding: list[PostgresLiveness] = []
    hold = PostgresLiveness.hold

    def noted(liveness: PostgresLiveness, executor: str, on_lost: Callable[[], None]) -> None:
        holding.append(liveness)
        hold(liveness, executor, on_lost)

    monkeypatch.setattr(PostgresLiveness, "hold", noted)
    yield
    for liveness in holding:
        liveness._lost.set()


@pytest.mark.usefixtures("no_proofs_after_the_test")
class TestLiveness:
    def is_dead(self, liveness: PostgresLiveness, executor: str) -> bool:
        with liveness.claim_dead(executor) as dead:
            return dead

    def test_a_worker_is_dead_once_its_lock_was_free_for_the_grace(self, home: Home, wait_until: Poll) -> None:
        liveness = PostgresLiveness(home.database_url, grace=0.3)
        assert not self.is_dead(liveness, "other")
        wait_until(lambda: self.is_dead(liveness, "other"), "the end of the grace")

    def test_until_then_it_is_suspected(self, home: Home, wait_until: Poll) -> None:
        liveness = PostgresLiveness(home.database_url, grace=0.3)
        assert not liveness.suspects("other")
        self.is_dead(liveness, "other")
        assert liveness.suspects("other")
        wait_until(lambda: self.is_dead(liveness, "other"), "the end of the grace")
        assert not liveness.suspects("other")

    def test_a_worker_that_holds_its_lock_is_alive(self, home: Home) -> None:
        PostgresLiveness(home.database_url).hold("other", lambda: None)
        assert not self.is_dead(PostgresLiveness(home.database_url, grace=0), "other")

    def test_a_look_at_another_takes_no_connection_more(self, home: Home, server: PostgresServer) -> None:
        liveness = PostgresLiveness(home.database_url, grace=0)
        liveness.hold("me", lambda: None)
        database = sa.make_url(home.database_url).database
        assert database
        others = "datname = current_database() AND pid <> pg_backend_pid()"
        with liveness.claim_dead("other") as dead:
            assert dead
            assert server.execute(database, f"SELECT count(*) FROM pg_stat_activity WHERE {others}")[0][0] == 1

    def test_only_one_can_claim_a_dead_worker_at_a_time(self, home: Home) -> None:
        first, second = (PostgresLiveness(home.database_url, grace=0) for _ in range(2))
        with first.claim_dead("other") as one, second.claim_dead("other") as two:
            assert (one, two) == (True, False)
        assert self.is_dead(second, "other")

    def test_a_worker_that_cannot_reach_the_server_ends_itself_within_its_patience(
        self, server: PostgresServer, home: Home
    ) -> None:
        lost = threading.Event()
        PostgresLiveness(home.database_url, patience=0.5, interval=0.05).hold("me", lost.set)
        server.stop()
        try:
            assert lost.wait(60)
        finally:
            server.start()

    def test_a_worker_that_reaches_the_server_again_takes_its_lock_again(
        self, server: PostgresServer, home: Home
    ) -> None:
        lost = threading.Event()
        PostgresLiveness(home.database_url, patience=10, interval=0.05).hold("me", lost.set)
        server.stop()
        server.start()
        observer = PostgresLiveness(home.database_url, grace=0.0)
        deadline = time.monotonic() + 60
        while self.is_dead(observer, "me"):
            assert time.monotonic() < deadline
            time.sleep(0.2)
        assert not lost.is_set()
