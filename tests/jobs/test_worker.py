"""Whole jobs, run by real worker processes on SQLite."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from jobs.artifacts.artifact_store import ArtifactStore, open_store
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import STAGES, StageBytes, StageSeconds
from jobs.process.memory_limit import CURE
from jobs.process.stage_sandbox import missing_from_stages
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import Job, JobState
from jobs.runs.progress_log import read_course
from jobs.worker import start_worker

Worker = subprocess.Popen[bytes]
WaitFor = Callable[[str, Callable[[Job], bool], str], Job]


def finished(job: Job) -> bool:
    return job.state.finished


def training(job: Job) -> bool:
    return job.stage == "train" and job.done > 0


def iterations(client: JobClient, job_id: str) -> list[int]:
    lines = (client.home.run(job_id) / "iterations.log").read_text().splitlines()
    return [int(line.split()[1]) for line in lines]


def test_a_job_becomes_a_published_scene(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    worker()
    job = wait_for(submit(), finished, "the end of the job")
    assert (job.state, job.error, job.stage, job.done) == (JobState.SUCCEEDED, "", "publish", job.total)
    assert job.scene_id == job.id
    store = ArtifactStore(client.home.store_url)
    assert [scene.id for scene in store.list_scenes()] == [job.scene_id]
    assert iterations(client, job.id) == list(range(10))


def test_a_job_that_exceeds_its_time_limit_fails_and_says_so(
    client: JobClient, tmp_path: Path, worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    (tmp_path / "behaviour").write_text("count")
    config = RunConfig().changed({"train.iterations": 100_000})
    worker()
    job = wait_for(client.submit(JobRequest(tmp_path, config, time_limit=2.0)), finished, "the end of the job")
    assert (job.state, job.error) == (JobState.FAILED, "took longer than its time limit of 2 s")
    assert client.retry(job.id).state is JobState.QUEUED


def test_the_course_and_the_log_of_a_job_are_in_its_run_folder(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    worker()
    run = client.home.run(submit(iterations=60))
    wait_for(run.name, finished, "the end of the job")
    course = [point for point in read_course(run) if point.stage == "train"]
    assert (course[-1].attempt, course[-1].done, course[-1].total) == (1, 60, 60)
    assert course[-1].figures == {"loss": 0.0}
    log = (run / "stage.log").read_text()
    assert [f"{stage} begins" in log for stage in STAGES] == [True] * len(STAGES)
    assert "publish is complete after" in log


def test_a_worker_runs_one_job_after_the_other(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    first, second = submit(iterations=60), submit(iterations=5)
    worker()
    wait_for(first, training, "the first job's training")
    seen = client.get(second)
    assert seen is not None
    assert seen.state is JobState.QUEUED
    assert wait_for(second, finished, "the end of the second job").state is JobState.SUCCEEDED
    ended = client.get(first)
    assert ended is not None
    assert ended.state is JobState.SUCCEEDED


def test_a_failed_job_says_why_and_a_retry_resumes_it(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, tmp_path: Path
) -> None:
    worker()
    job_id = submit(iterations=20, behaviour="raise")
    job = wait_for(job_id, finished, "the failure")
    assert (job.state, job.error) == (JobState.FAILED, "RuntimeError: the loss is not a number")
    assert ArtifactStore(client.home.store_url).list_scenes() == []

    (tmp_path / "capture" / "behaviour").write_text("count")
    client.retry(job_id)
    assert wait_for(job_id, finished, "the end of the retry").state is JobState.SUCCEEDED
    assert iterations(client, job_id) == [*range(11), *range(10, 20)]  # the last checkpoint before the failure was 10


def test_a_stage_that_was_killed_is_tried_again(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    worker()
    job = wait_for(submit(iterations=20, behaviour="die once"), finished, "the end of the job")
    assert job.state is JobState.SUCCEEDED
    assert iterations(client, job.id) == [*range(11), *range(10, 20)]


def test_a_stage_that_is_always_killed_fails_the_job(
    submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    worker()
    job = wait_for(submit(iterations=4, behaviour="die"), finished, "the failure")
    assert job.state is JobState.FAILED
    assert job.error.startswith("train: ended by SIGKILL ")  # and then whether the system lacked memory


@pytest.mark.skipif(bool(missing_from_stages()), reason=missing_from_stages())
@pytest.mark.parametrize("own", [True, False])
def test_a_stage_reads_no_file_of_another_capture(
    submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor, tmp_path: Path, own: bool
) -> None:
    for name in ("capture", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "video.mp4").touch()
    (tmp_path / "capture" / "elsewhere").write_text(str(tmp_path / ("capture" if own else "other") / "video.mp4"))
    worker()
    job = wait_for(submit(iterations=4, behaviour="spy"), finished, "the end of the job")
    assert job.error.startswith("" if own else "PermissionError: ")
    assert job.state is (JobState.SUCCEEDED if own else JobState.FAILED)


@pytest.mark.skipif(sys.platform != "linux", reason="no other system limits what a process may take")
def test_a_memory_hog_ends_alone(
    client: JobClient, submit: Callable[..., str], worker: Callable[..., Worker], wait_for: WaitFor
) -> None:
    process = worker(limits=StageLimits(memory=StageBytes.parse("LIMIT", "8G,train=1G")))
    job = wait_for(submit(iterations=20, behaviour="hog"), finished, "the failure")
    assert job.state is JobState.FAILED
    assert job.error.startswith("out of memory: Unable to allocate 64.0 MiB")
    assert job.error.endswith(CURE)
    assert wait_for(submit(iterations=1), finished, "the next job").state is JobState.SUCCEEDED
    assert process.poll() is None


@pytest.mark.slow
def test_a_stage_that_hangs_is_started_again(
    home: Home, client: JobClient, submit: Callable[..., str], worker: Callable[..., Worker], wait_for: WaitFor
) -> None:
    worker(limits=StageLimits(StageSeconds(5.0)))
    job = wait_for(submit(iterations=20, behaviour="hang once"), finished, "the end of the job")
    assert (job.state, job.attempt) == (JobState.SUCCEEDED, 1)
    assert iterations(client, job.id) == [*range(11), *range(10, 20)]


def test_a_cancelled_job_stops_and_frees_the_worker(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    worker()
    job_id = submit(iterations=100_000)
    wait_for(job_id, training, "training")
    assert client.cancel(job_id).state is JobState.CANCELLED
    assert wait_for(submit(iterations=5), finished, "the end of the next job").state is JobState.SUCCEEDED
    assert int((client.home.run(job_id) / "checkpoint.pt").read_text()) == len(iterations(client, job_id))
    job = client.get(job_id)
    assert job is not None
    assert job.state is JobState.CANCELLED


def test_a_job_that_is_cancelled_while_it_publishes_leaves_no_scene(
    home: Home,
    client: JobClient,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    wait_until: Callable[[Callable[[], bool], str], None],
) -> None:
    store = open_store(home)
    with store.lock.collecting(60):  # publishers wait
        worker()
        job_id = submit(iterations=1)
        wait_for(job_id, lambda job: job.stage == "publish" and job.total > 1, "its publication")
        assert client.cancel(job_id).state is JobState.CANCELLED
    other = submit(iterations=1)
    assert wait_for(other, finished, "the end of the next job").state is JobState.SUCCEEDED
    # Its place is free at once, so the next job may come to its end before this one's scene is taken back.
    wait_until(lambda: [scene.id for scene in store.list_scenes()] == [other], "the end of the cancelled scene")


def test_a_stopped_worker_saves_and_another_goes_on_without_losing_an_iteration(
    client: JobClient,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
) -> None:
    first = worker()
    job_id = submit(iterations=100)
    wait_for(job_id, training, "training")
    first.send_signal(signal.SIGTERM)
    assert first.wait(60) == 0
    job = client.get(job_id)
    assert job is not None
    assert (job.state, job.waiting) == (JobState.QUEUED, "its worker was stopped; the next free one goes on with it")
    assert 0 < len(iterations(client, job_id)) < 100

    worker()
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED
    assert iterations(client, job_id) == list(range(100))


def test_a_started_worker_ends_with_its_parent(
    client: JobClient, submit: Callable[..., str], wait_for: WaitFor
) -> None:
    process = start_worker(client.home)
    try:
        assert wait_for(submit(iterations=3), finished, "the end of the job").state is JobState.SUCCEEDED
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.wait()


def test_a_job_whose_workflow_broke_is_failed(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    job_id = submit()
    client.home.run(job_id).rename(client.home.folder / "moved")
    worker()
    job = wait_for(job_id, finished, "the failure")
    assert job.state is JobState.FAILED
    assert "stage.log" in job.error


def test_a_cancel_that_was_cut_off_is_completed(
    client: JobClient,
    submit: Callable[..., str],
    worker: Callable[[], Worker],
    wait_for: WaitFor,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    job_id = submit()
    with monkeypatch.context() as patch:
        patch.setattr(client._table, "cancel", lambda *_: False)  # a death between the two writes
        client.cancel(job_id)
    worker()
    assert wait_for(job_id, finished, "the cancellation").state is JobState.CANCELLED


def test_a_job_under_which_too_many_workers_died_is_failed(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    job_id = submit()
    with client._engine.begin() as connection:  # DBOS's row after the last allowed take-over
        connection.exec_driver_sql("UPDATE workflow_status SET status = 'MAX_RECOVERY_ATTEMPTS_EXCEEDED'")
    worker()
    job = wait_for(job_id, finished, "the failure")
    assert (job.state, job.error) == (JobState.FAILED, "given up: 20 workers died while they ran this job")


@pytest.mark.slow
def test_a_workflow_of_a_living_worker_that_nobody_works_on_is_resumed(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    job_id = submit(iterations=3)
    hold = "UPDATE workflow_status SET queue_name = 'nowhere'"
    dropped = "UPDATE workflow_status SET queue_name = 'training', status = 'PENDING', executor_id = ?"
    running = "UPDATE hgs_job SET state = 'running'"
    with client._engine.begin() as connection:
        connection.exec_driver_sql(hold)
    worker()
    live = client.home.folder / "live"
    wait_for(job_id, lambda job: live.exists() and any(path.name[0] != "." for path in live.iterdir()), "the worker")
    (executor,) = [path.name for path in live.iterdir()]
    with client._engine.begin() as connection:  # an unwritten end
        connection.exec_driver_sql(dropped, (executor,))
        connection.exec_driver_sql(running)
    assert wait_for(job_id, finished, "the end of the job").state is JobState.SUCCEEDED


def test_progress_that_cannot_be_written_fails_nothing(
    client: JobClient, submit: Callable[..., str], worker: Callable[[], Worker], wait_for: WaitFor
) -> None:
    with client._engine.begin() as connection:
        connection.exec_driver_sql(
            "CREATE TRIGGER refuse BEFORE UPDATE OF done ON hgs_job BEGIN SELECT RAISE(ABORT, 'refused'); END"
        )
    worker()
    job = wait_for(submit(), finished, "the end of the job")
    assert (job.state, job.done) == (JobState.SUCCEEDED, 0)
    assert (client.home.run(job.id) / "train.json").exists()
