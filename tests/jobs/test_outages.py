"""Faults of the store, a disk or a mount: the job waits, says why, and goes on when they have passed."""

from __future__ import annotations

import contextlib
import dataclasses
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from small_disk import small_disk

from hgs_core.runs.run_folder import RunFolder
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.queue.client import JobClient
from jobs.queue.enqueue import enqueue
from jobs.records.job import Job, JobState

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]


def finished(job: Job) -> bool:
    return job.state.finished


def waits(job: Job) -> bool:
    return bool(job.waiting) or job.state.finished


def iterations(client: JobClient, job_id: str) -> list[int]:
    lines = (client.home.run(job_id) / "iterations.log").read_text().splitlines()
    return [int(line.split()[1]) for line in lines]


@pytest.fixture
def store_is_away(home: Home) -> Callable[[], None]:
    """Make every write to the store fail; return the function that brings it back."""
    chunks = Path(home.store_url.removeprefix("file://")) / "chunks"
    chunks.parent.mkdir(parents=True)
    chunks.touch()  # a file where the store wants a folder
    return chunks.unlink


@pytest.mark.slow
def test_a_store_that_is_away_keeps_the_job_waiting(
    client: JobClient,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    store_is_away: Callable[[], None],
) -> None:
    worker()
    job_id = submit()
    job = wait_for(job_id, waits, "the fault")
    assert (job.state, job.stage, job.attempt, job.error) == (JobState.WAITING, "publish", 2, "")
    assert job.waiting.startswith("the store fails: ")
    assert len(job.waiting) <= 220
    assert "\n" not in job.waiting

    younger = wait_for(submit(), waits, "another job, which the worker is free for")
    assert younger.waiting.startswith("the store fails: ")
    assert client.cancel(younger.id).state is JobState.CANCELLED

    store_is_away()
    job = wait_for(job_id, finished, "the end of the job")
    assert (job.state, job.waiting) == (JobState.SUCCEEDED, "")
    log = (client.home.run(job_id) / "stage.log").read_text()
    assert log.count("a library that prints to stdout") == 1  # the stages before are not even begun again
    assert iterations(client, job_id) == list(range(10))
    assert [scene.id for scene in ArtifactStore(client.home.store_url).list_scenes()] == [job_id]
    after = client.get(younger.id)
    assert after is not None
    assert (after.state, after.waiting) == (JobState.CANCELLED, "")


def test_a_job_that_waits_for_hours_goes_on_when_its_capture_is_seen(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    job_id = submit()
    client.cancel(job_id)
    with client._engine.begin() as connection:
        client._table.requeue(connection, job_id, 1)
        client._table.put_off(connection, job_id, 2, "the capture cannot be reached", Cause.CAPTURE)
        enqueue(client._queue, connection, job_id, 3, delay=7200.0, waits=12)
    worker()
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED


@pytest.mark.slow
def test_a_capture_that_is_not_mounted_is_waited_for(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, tmp_path: Path
) -> None:
    job_id = submit()
    (tmp_path / "capture").rename(tmp_path / "elsewhere")
    worker()
    job = wait_for(job_id, waits, "the fault")
    assert job.waiting.startswith(f"{tmp_path / 'capture'}: the capture cannot be reached")
    (tmp_path / "elsewhere").rename(tmp_path / "capture")
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED


@pytest.mark.slow
def test_a_database_that_does_not_take_the_outcome_of_a_stage_is_waited_for(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    with client._engine.begin() as connection:
        connection.exec_driver_sql(
            "CREATE TRIGGER refuse BEFORE INSERT ON operation_outputs BEGIN SELECT RAISE(ABORT, 'refused'); END"
        )
    worker()
    job_id = submit()
    job = wait_for(job_id, waits, "the fault")
    assert (job.state, job.waiting) == (JobState.WAITING, "the job database fails: refused")
    with client._engine.begin() as connection:
        connection.exec_driver_sql("DROP TRIGGER refuse")
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    with small_disk(tmp_path / "disk", megabytes=24) as folder:
        yield folder


class TestFullDisk:
    """Database, runs and store on a real disk that is really full."""

    @pytest.fixture
    def home(self, disk: Path, pipeline: str) -> Home:
        return dataclasses.replace(Home.at(disk / "home"), pipeline=pipeline)

    @pytest.mark.slow
    def test_the_job_goes_on_when_there_is_room_again(
        self,
        client: JobClient,
        submit: Callable[..., str],
        worker: Callable[[], Worker],
        wait_for: WaitFor,
        disk: Path,
    ) -> None:
        worker()
        job_id = submit(iterations=200)
        wait_for(job_id, lambda job: job.stage == "train" and job.done > 20, "training")
        ballast = disk / "ballast"
        fill(ballast)
        wait_until_unlocked(client.home.run(job_id))
        fill(ballast)  # space freed by the stage included
        with pytest.raises(OSError, match="No space left"):
            submit()
        assert len(list(client.home.runs.iterdir())) == 1  # nothing half made stays
        ballast.unlink()
        job = wait_for(job_id, finished, "the end of the job")
        assert (job.state, job.error) == (JobState.SUCCEEDED, "")
        assert sorted(set(iterations(client, job_id))) == list(range(200))


def fill(path: Path) -> None:
    """Add to a file until its disk is full to the last page."""
    with path.open("ab", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(bytes(4096))


def wait_until_unlocked(run: Path) -> None:
    with RunFolder(run).exclusive(patience=240):
        pass
