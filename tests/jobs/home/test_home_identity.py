"""A machine without the shared home takes no job and makes none."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from postgres_server import PostgresServer

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.records.job import Job, JobState

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]
Poll = Callable[[Callable[[], bool], str], None]


@pytest.fixture
def home(tmp_path: Path, pipeline: str, server: PostgresServer) -> Home:
    """The database is not inside the folder, as on several machines."""
    return dataclasses.replace(Home.at(tmp_path / "home"), pipeline=pipeline, database_url=server.new_database())


def elsewhere(home: Home, folder: Path) -> Home:
    """Return the home as a machine sees it on which `folder` is in the place of the shared one."""
    return dataclasses.replace(home, folder=folder)


def test_another_folder_is_refused(home: Home, client: JobClient, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=f"HGS_HOME {tmp_path}/bare: is not the home of this database: it has no home-id"
    ):
        JobClient(elsewhere(home, tmp_path / "bare"))
    assert not (tmp_path / "bare").exists()


def test_the_home_of_another_database_is_refused(
    home: Home, client: JobClient, server: PostgresServer, tmp_path: Path
) -> None:
    other = dataclasses.replace(Home.at(tmp_path / "other"), database_url=server.new_database())
    JobClient(other).close()
    with pytest.raises(InputError, match="is the home of another database"):
        JobClient(elsewhere(home, other.folder))


def test_the_cure_that_is_named_cures(home: Home, client: JobClient, tmp_path: Path) -> None:
    known = (home.folder / "home-id").read_text()
    (tmp_path / "new").mkdir()
    with pytest.raises(InputError, match=f"write {known} into {tmp_path}/new/home-id"):
        JobClient(elsewhere(home, tmp_path / "new"))
    (tmp_path / "new" / "home-id").write_text(f"{known}\n")
    JobClient(elsewhere(home, tmp_path / "new")).close()


def test_a_new_database_takes_an_old_home(home: Home, client: JobClient, server: PostgresServer) -> None:
    JobClient(dataclasses.replace(home, database_url=server.new_database())).close()
    JobClient(home).close()


def test_a_worker_without_the_home_ends_with_one_line(
    home: Home, client: JobClient, submit: Callable[..., str], tmp_path: Path
) -> None:
    job_id = submit()
    bare = elsewhere(home, tmp_path / "bare")
    command = [sys.executable, "-m", "jobs.worker"]
    ended = subprocess.run(
        command, env={**os.environ, **bare.environment()}, capture_output=True, text=True, timeout=240, check=False
    )
    assert ended.returncode == 1
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"hgs worker: HGS_HOME {tmp_path}/bare: is not the home of this database")
    job = client.get(job_id)
    assert job is not None
    assert (job.state, job.attempt) == (JobState.QUEUED, 1)


def test_a_worker_whose_home_vanishes_takes_no_job(
    home: Home, client: JobClient, submit: Callable[..., str], wait_for: WaitFor, wait_until: Poll, tmp_path: Path
) -> None:
    log = tmp_path / "worker.log"
    with (
        log.open("wb") as file,
        subprocess.Popen(
            [sys.executable, "-m", "jobs.worker"], env={**os.environ, **home.environment()}, stderr=file
        ) as worker,
    ):
        try:
            wait_until(lambda: "is ready" in log.read_text(), "the worker")
            (home.folder / "home-id").rename(home.folder / "away")
            wait_until(lambda: f"takes no job: HGS_HOME {home.folder}" in log.read_text(), "the worker to notice")
            job_id = submit(iterations=1)
            time.sleep(3)  # it looks into the queue twice a second
            job = client.get(job_id)
            assert job is not None
            assert job.state is JobState.QUEUED
            (home.folder / "away").rename(home.folder / "home-id")
            assert wait_for(job_id, lambda job: job.state.finished, "the end of the job").state is JobState.SUCCEEDED
        finally:
            worker.kill()


@pytest.mark.slow
def test_a_run_that_was_begun_on_a_home_that_vanished_waits(
    home: Home, client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    job_id = submit(iterations=200)
    worker()
    wait_for(job_id, lambda job: job.stage == "train" and job.done > 20, "training")
    home.folder.rename(home.folder.parent / "unmounted")
    job = wait_for(job_id, lambda job: bool(job.waiting) or job.state.finished, "the fault")
    assert "is not the home of this database" in job.waiting
    (home.folder.parent / "unmounted").rename(home.folder)
    assert wait_for(job_id, lambda job: job.state.finished, "the end of the job").state is JobState.SUCCEEDED
