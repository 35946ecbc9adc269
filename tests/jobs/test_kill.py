"""A worker killed with -9 in the middle of training costs no job, and nothing is trained twice."""

from __future__ import annotations

import fcntl
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import Job, JobState

SAMPLE = Path(__file__).resolve().parent.parent.parent / "samples" / "studio"

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]
Poll = Callable[[Callable[[], bool], str], None]


def finished(job: Job) -> bool:
    return job.state.finished


def iterations(run: Path) -> list[tuple[int, int]]:
    """Return the process id and the number of every iteration that was trained, in the order they were trained in."""
    log = run / "iterations.log"
    lines = log.read_text().splitlines() if log.exists() else []
    return [(int(pid), int(iteration)) for pid, iteration in (line.split() for line in lines)]


def is_worked_on(run: Path) -> bool:
    with (run / "run.lock").open() as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        return False


@pytest.mark.parametrize("standby", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_another_worker_resumes_from_the_checkpoint(
    client: JobClient,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    wait_until: Poll,
    standby: bool,
) -> None:
    job_id = submit(iterations=150)
    run = client.home.run(job_id)
    first = worker()
    wait_until(lambda: len(iterations(run)) >= 12, "twelve iterations")
    other = worker() if standby else None
    first.send_signal(signal.SIGKILL)
    first.wait()
    if other is None:
        younger = submit(iterations=1)
        worker()
        wait_for(younger, finished, "the end of the younger job")
        resumed = client.get(job_id)
        assert resumed is not None
        assert resumed.state.finished  # the interrupted one came first

    job = wait_for(job_id, finished, "the end of the job")
    assert (job.state, job.error, job.attempt) == (JobState.SUCCEEDED, "", 1)
    trained = iterations(run)
    pids = list(dict.fromkeys(pid for pid, _ in trained))
    before, after = ([done for pid, done in trained if pid == own] for own in pids)  # exactly two processes trained
    assert trained == [(pids[0], done) for done in before] + [(pids[1], done) for done in after]  # never at once
    assert before == list(range(len(before)))
    assert after == list(range(after[0], 150))
    assert after[0] % 5 == 0  # a checkpoint,
    assert 10 <= after[0] <= len(before) < after[0] + 5  # the last one


def test_a_killed_worker_leaves_no_orphan(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_until: Poll
) -> None:
    job_id = submit(iterations=100_000, behaviour="deaf")
    run = client.home.run(job_id)
    process = worker()
    wait_until(lambda: len(iterations(run)) >= 1, "the first iteration")
    assert is_worked_on(run)
    process.kill()
    process.wait()
    wait_until(lambda: not is_worked_on(run), "the end of the stage")


def test_a_paused_worker_is_not_taken_for_dead(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    job_id = submit(iterations=100)
    run = client.home.run(job_id)
    first = worker()
    wait_until(lambda: len(iterations(run)) >= 1, "the first iteration")
    first.send_signal(signal.SIGSTOP)
    worker()
    wait_until(lambda: len(iterations(run)) == 100, "the stage's end, which nobody hears of yet")
    job = client.get(job_id)
    assert job is not None
    assert job.state is JobState.RUNNING
    first.send_signal(signal.SIGCONT)
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED
    assert [iteration for _, iteration in iterations(run)] == list(range(100))


def test_a_job_that_was_cancelled_while_its_worker_was_dead_stays_cancelled(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    job_id = submit(iterations=100_000)
    run = client.home.run(job_id)
    first = worker()
    wait_until(lambda: len(iterations(run)) >= 1, "the first iteration")
    first.kill()
    first.wait()
    client.cancel(job_id)
    wait_until(lambda: not is_worked_on(run), "the end of the orphan")
    trained = iterations(run)
    worker()
    assert wait_for(submit(iterations=3), finished, "the end of the next job").state is JobState.SUCCEEDED
    job = client.get(job_id)
    assert job is not None
    assert job.state is JobState.CANCELLED
    assert iterations(run) == trained


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["hgs_core.runs.stages"])
def test_the_real_trainer_resumes_from_its_checkpoint(
    client: JobClient, worker: Callable[[], Worker], wait_for: WaitFor, wait_until: Poll
) -> None:
    config = RunConfig.from_json(
        {
            "capture": {"hold_out": [f"cam{i:02}" for i in range(4, 16)]},  # four cameras are enough here, and faster
            "points": {"static": 1000, "dynamic": 300, "interval": 2.0},
            "train": {"iterations": 300, "checkpoint_every": 20},
        }
    )
    job_id = client.submit(JobRequest(SAMPLE, config))
    run = client.home.run(job_id)
    first = worker()
    wait_for(job_id, lambda job: (run / "checkpoint.pt").exists() or finished(job), "the first checkpoint")
    first.kill()
    first.wait()
    wait_until(lambda: not is_worked_on(run), "the end of the orphan")
    assert not (run / "train.json").exists()

    reports: list[int] = []

    def report(job: Job) -> bool:
        if job.stage == "train" and job.total == config.train.iterations:
            reports.append(job.done)
        return finished(job)

    worker()
    wait_for(job_id, lambda job: (job.stage, job.total) == ("train", 1), "the second start of the stage")
    job = wait_for(job_id, report, "the end of the job")
    assert (job.state, job.error) == (JobState.SUCCEEDED, "")
    assert min(reports) >= config.train.checkpoint_every
    assert (run / "train.json").exists()
    assert ArtifactStore(client.home.store_url).manifest(job_id) is not None
