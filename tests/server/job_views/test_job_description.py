from __future__ import annotations

import dataclasses

import pytest

from jobs.records.job import Job, JobState
from jobs.records.worker_register import Worker
from server.job_views.job_description import describe_job, describe_worker, revision

JOB = Job(id="a", capture="studio", title="Studio", config={}, state=JobState.RUNNING, created=1.0, updated=2.0)


def test_a_description_leaves_the_secret_path_of_a_webhook_out() -> None:
    job = dataclasses.replace(JOB, webhook="https://example.org:8443/secret/path?token=1")
    assert describe_job(job)["webhook"] == "https://example.org:8443"


@pytest.mark.parametrize(("state", "ends"), [(JobState.RUNNING, 9.0), (JobState.FAILED, None)])
def test_only_a_running_job_has_an_end_of_its_stage(state: JobState, ends: float | None) -> None:
    assert describe_job(dataclasses.replace(JOB, state=state, ends=9.0))["ends"] == ends


def test_a_figure_beyond_json_is_left_out() -> None:
    job = dataclasses.replace(JOB, stage="train", done=1, total=2, figures={"psnr": 30.0, "loss": float("nan")})
    assert describe_job(job)["progress"] == {"stage": "train", "done": 1, "total": 2, "figures": {"psnr": 30.0}}


def test_a_revision_changes_with_every_change_of_the_job() -> None:
    changed = [JOB, dataclasses.replace(JOB, updated=2.5), dataclasses.replace(JOB, attempt=JOB.attempt + 1)]
    assert len({revision(job) for job in changed}) == 3


def test_an_idle_worker_has_no_job() -> None:
    worker = Worker(id="w", host="node", pid=1, device="", job_id="", idle_because="", started=1.0, seen=2.0)
    assert describe_worker(worker)["job"] is None
