"""Segments of one job on several workers."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.stages import train_scene
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job import Job, JobState
from tests.synthetic import write_capture

stand_in = pytest.mark.parametrize("pipeline", ["segment_pipeline"])

WaitFor = Callable[[str, Callable[[Job], bool], str], Job]


def submitted(client: JobClient, capture: Path, segments: int, pace: float, iterations: int = 5) -> str:
    capture.mkdir()
    (capture / "segments").write_text(str(segments))
    (capture / "pace").write_text(str(pace))
    return client.submit(JobRequest(capture, RunConfig().changed({"train.iterations": iterations})))


def lines(file: Path) -> list[list[str]]:
    return [line.split() for line in file.read_text().splitlines()] if file.exists() else []


def live(client: JobClient, job_id: str) -> int | None:
    """The number of the published manifest, 0 for none; None once the scene is complete."""
    manifest = ArtifactStore(client.home.store_url).manifest(job_id)
    return 0 if manifest is None else json.loads(manifest).get("live")


@stand_in
def test_workers_share_the_segments_of_a_job_and_one_that_dies_costs_what_it_had_not_saved(
    client: JobClient, worker: Callable[..., subprocess.Popen[bytes]], wait_for: WaitFor, tmp_path: Path
) -> None:
    workers = {process.pid: process for process in (worker(), worker(), worker())}
    job_id = submitted(client, tmp_path / "capture", 6, 0.01)
    run = client.home.run(job_id)
    (run / "hold").touch()
    wait_for(job_id, lambda job: len({worker for _, worker in lines(run / "begun.log")}) == 3, "help")
    assert live(client, job_id) == 1
    first = lines(run / "begun.log")[0][1]
    helper = next(worker for _, worker in lines(run / "begun.log") if worker != first)
    workers[int(helper)].kill()
    (run / "hold").unlink()
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert job.state is JobState.SUCCEEDED
    assert live(client, job_id) is None
    assert {made[0] for made in lines(run / "made.log")} == set("012345")
    steps = [tuple(step) for step in lines(run / "iterations.log")]
    assert len(steps) - len(set(steps)) <= 1  # the killed one's last


@stand_in
@pytest.mark.slow
def test_one_worker_makes_all_segments_and_help_that_comes_too_late_ends_at_once(
    client: JobClient, worker: Callable[..., subprocess.Popen[bytes]], wait_for: WaitFor, tmp_path: Path
) -> None:
    worker()
    job_id = submitted(client, tmp_path / "capture", 3, 0.02)
    assert wait_for(job_id, lambda job: job.state.finished, "the end of the job").state is JobState.SUCCEEDED
    assert [made[0] for made in lines(client.home.run(job_id) / "made.log")] == list("012")
    other = submitted(client, tmp_path / "other", 1, 0.02)
    assert wait_for(other, lambda job: job.state.finished, "the end of the other").state is JobState.SUCCEEDED


@pytest.mark.slow
@stand_in
def test_helpers_of_a_cancelled_job_stop(
    client: JobClient, worker: Callable[..., subprocess.Popen[bytes]], wait_for: WaitFor, tmp_path: Path
) -> None:
    worker(), worker()
    job_id = submitted(client, tmp_path / "capture", 3, 0.01)
    run = client.home.run(job_id)
    (run / "hold").touch()
    wait_for(job_id, lambda job: len({worker for _, worker in lines(run / "begun.log")}) == 2, "help")
    client.cancel(job_id)
    other = submitted(client, tmp_path / "other", 1, 0.02)
    assert wait_for(other, lambda job: job.state.finished, "the end of the other").state is JobState.SUCCEEDED
    job = client.get(job_id)
    assert job is not None
    assert job.state is JobState.CANCELLED


@pytest.mark.slow
@pytest.mark.parametrize("pipeline", ["hgs_core.runs.stages"])
def test_workers_make_the_same_bits_as_one_process(
    client: JobClient, worker: Callable[..., subprocess.Popen[bytes]], wait_for: WaitFor, tmp_path: Path
) -> None:
    write_capture(tmp_path / "capture")
    config = RunConfig.from_json(
        {
            "capture": {"hold_out": ["2"]},
            "points": {"static": 200, "dynamic": 40, "interval": 0.1},
            "train": {"iterations": 60, "checkpoint_every": 10, "segment_frames": 2},
            "encode": {"by_segment": True},
        }
    )
    worker(), worker()
    job_id = client.submit(JobRequest(tmp_path / "capture", config))
    job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
    assert job.state is JobState.SUCCEEDED, job.error
    alone = train_scene(tmp_path / "capture", tmp_path / "alone", config)
    run = client.home.run(job_id)
    assert (run / "scene.npz").read_bytes() == (alone / "scene.npz").read_bytes()
    manifests = [json.loads((folder / "scene" / "manifest.json").read_text()) for folder in (run, alone)]
    for manifest in manifests:
        del manifest["training"]["seconds"]
    assert manifests[0] == manifests[1]
    assert live(client, job_id) is None
