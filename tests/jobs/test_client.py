from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.config import RunConfig
from jobs.client import JobClient, JobConflictError, JobRequest
from jobs.home import Home
from jobs.store import JobState


def test_a_submitted_job_is_queued_with_its_run_folder(
    client: JobClient, submit: Callable[..., str], tmp_path: Path
) -> None:
    job_id = submit(iterations=7)
    job = client.get(job_id)
    assert job is not None
    assert job.state is JobState.QUEUED
    assert job.title == "capture"
    assert job.capture == str(tmp_path / "capture")
    assert RunConfig.from_json(dict(job.config)) == RunConfig().changed({"train.iterations": 7})
    assert (client.home.run(job_id) / "run.json").is_file()


def test_the_id_is_readable_and_safe(client: JobClient, tmp_path: Path) -> None:
    (tmp_path / "behaviour").touch()
    job_id = client.submit(JobRequest(tmp_path, RunConfig(), title="  Große Show / Take #2 " + "x" * 99))
    assert job_id.startswith("gro-e-show-take-2-x")
    assert len(job_id) <= 49
    assert set(job_id) <= set("abcdefghijklmnopqrstuvwxyz0123456789-")


def test_a_bad_capture_raises_and_leaves_nothing(client: JobClient, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no file `behaviour`"):
        client.submit(JobRequest(tmp_path, RunConfig()))
    assert client.list() == []
    assert list(client.home.runs.iterdir()) == []


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        ({"title": "x" * 201}, "title"),
        ({"title": "a\0b"}, "title"),
        ({"title": "\ud800"}, "title"),
        ({"title": "two\nlines"}, "title"),
        ({"title": "\x1b[2J"}, "title"),
        ({"masks": Path("a\udc80")}, "masks"),
        ({"capture": Path("a\udc80")}, "capture"),
        ({"capture": Path("a" * 5000)}, "capture"),
    ],
)
def test_text_that_cannot_be_stored_or_shown_is_refused_by_name(
    tmp_path: Path, fields: dict[str, Any], where: str
) -> None:
    with pytest.raises(InputError) as refused:
        JobRequest(**{"capture": tmp_path, "config": RunConfig(), **fields})
    assert refused.value.where == where
    str(refused.value).encode()


def test_a_link_to_a_name_that_cannot_be_stored_is_refused(client: JobClient, tmp_path: Path) -> None:
    (tmp_path / "a\udc80").mkdir()
    (tmp_path / "a\udc80" / "behaviour").touch()
    (tmp_path / "link").symlink_to(tmp_path / "a\udc80")
    with pytest.raises(InputError, match=r"capture: .* holds NUL or half a surrogate pair"):
        client.submit(JobRequest(tmp_path / "link", RunConfig()))
    assert (client.list(), list(client.home.runs.iterdir())) == ([], [])


def test_the_title_of_a_capture_with_a_strange_name_is_one_line(client: JobClient, tmp_path: Path) -> None:
    capture = tmp_path / "two\nlines"
    capture.mkdir()
    (capture / "behaviour").touch()
    job = client.get(client.submit(JobRequest(capture, RunConfig())))
    assert job is not None
    assert (job.title, job.capture) == ("two lines", str(capture))


def test_a_job_that_cannot_be_queued_leaves_nothing(
    client: JobClient, submit: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr("jobs.client.enqueue", refuse)
    with pytest.raises(OSError, match="the disk is full"):
        submit()
    assert client.list() == []
    assert list(client.home.runs.iterdir()) == []


def test_jobs_are_listed_newest_first(client: JobClient, submit: Callable[..., str]) -> None:
    first, second = submit(), submit()
    assert [job.id for job in client.list()] == [second, first]


def test_a_queued_job_is_cancelled_at_once(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    assert client.cancel(job_id).state is JobState.CANCELLED
    assert client.cancel(job_id).state is JobState.CANCELLED


def test_a_cancelled_job_can_be_retried(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    client.cancel(job_id)
    job = client.retry(job_id)
    assert (job.state, job.attempt) == (JobState.QUEUED, 2)


def test_a_queued_job_cannot_be_retried(client: JobClient, submit: Callable[..., str]) -> None:
    with pytest.raises(JobConflictError, match="is queued"):
        client.retry(submit())


def test_an_unknown_job(client: JobClient) -> None:
    assert client.get("nobody") is None
    for action in (client.cancel, client.retry):
        with pytest.raises(KeyError):
            action("nobody")


def test_two_clients_share_one_home(home: Home, client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    with JobClient(home) as other:
        assert other.get(job_id) == client.get(job_id)


def test_the_queue_never_imports_torch() -> None:
    modules = "jobs.client, jobs.artifacts, jobs.worker, jobs.stage"
    code = f"import sys, {modules}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
