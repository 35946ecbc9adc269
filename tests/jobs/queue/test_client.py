from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from jobs.artifacts.artifact_store import open_store
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.queue.client import JobClient, JobConflictError, KeyReusedError
from jobs.queue.edit_request import EditRequest
from jobs.queue.enqueue import enqueue, workflow_id
from jobs.queue.job_request import JobRequest
from jobs.records.job import JobState
from jobs.runs.run_trash import trash


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
    def refuse(*_: object, **__: object) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr("jobs.queue.client.enqueue", refuse)
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


def test_a_waiting_job_is_tried_at_once(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    client.cancel(job_id)
    with client._engine.begin() as connection:
        client._table.requeue(connection, job_id, 1)
        client._table.put_off(connection, job_id, 2, "the store fails", Cause.STORE)
        enqueue(client._queue, connection, job_id, 3, delay=7200.0)
    job = client.retry(job_id)
    assert (job.state, job.attempt, job.waiting) == (JobState.QUEUED, 3, "")
    (status,) = client._queue.list_workflows(workflow_ids=[workflow_id(job_id, 3)])
    assert status.delay_until_epoch_ms is not None
    assert status.delay_until_epoch_ms / 1000 <= time.time()


def test_an_unknown_job(client: JobClient) -> None:
    assert client.get("nobody") is None
    for action in (client.cancel, client.retry, client.delete):
        with pytest.raises(KeyError):
            action("nobody")


def test_two_clients_share_one_home(home: Home, client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    with JobClient(home) as other:
        assert other.get(job_id) == client.get(job_id)


def test_the_queue_never_imports_torch() -> None:
    modules = "jobs.queue.client, jobs.artifacts.artifact_store, jobs.worker, jobs.stage"
    code = f"import sys, {modules}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def ask(tmp_path: Path, **fields: Any) -> JobRequest:
    capture = tmp_path / "capture"
    capture.mkdir(exist_ok=True)
    (capture / "behaviour").write_text("count")
    return JobRequest(capture, RunConfig(), **fields)


def test_what_is_asked_for_beside_the_config_is_kept(client: JobClient, tmp_path: Path) -> None:
    job = client.get(
        client.submit(ask(tmp_path, labels=("night",), priority=7, time_limit=60.0, given=GivenFiles(audio="none")))
    )
    assert job is not None
    assert (job.labels, job.priority, job.time_limit, job.audio) == (("night",), 7, 60.0, "none")


def test_the_same_key_is_the_same_job(client: JobClient, tmp_path: Path) -> None:
    first = client.submit(ask(tmp_path, key="k-1"))
    assert client.submit(ask(tmp_path, key="k-1")) == first
    assert client.submit(ask(tmp_path, key="k-2")) != first
    assert len(list(client.home.runs.iterdir())) == 2


def test_a_key_for_another_request_is_refused(client: JobClient, tmp_path: Path) -> None:
    client.submit(ask(tmp_path, key="k-1"))
    with pytest.raises(KeyReusedError, match="k-1"):
        client.submit(ask(tmp_path, key="k-1", title="Another"))


def test_the_same_key_at_the_same_moment_is_one_job(home: Home, tmp_path: Path) -> None:
    with JobClient(home) as one, JobClient(home) as other, ThreadPoolExecutor(8) as pool:
        clients = [one, other] * 4
        ids = set(pool.map(lambda client: client.submit(ask(tmp_path, key="k-1")), clients))
    assert len(ids) == 1
    assert [path.name for path in home.runs.iterdir()] == [*ids]


def test_the_same_key_is_the_same_edit(client: JobClient, scene: Path) -> None:
    open_store(client.home).put_scene(scene, "studio")
    first = client.edit(EditRequest("studio", b"a list", key="k-1"))
    assert client.edit(EditRequest("studio", b"a list", key="k-1")) == first
    assert client.edit(EditRequest("studio", b"a list")) != first
    assert len(list(client.home.runs.iterdir())) == 2


def test_the_same_edit_at_the_same_moment_leaves_one_run(client: JobClient, scene: Path) -> None:
    open_store(client.home).put_scene(scene, "studio")
    with ThreadPoolExecutor(8) as pool:
        ids = set(pool.map(client.edit, [EditRequest("studio", b"a list", key="k-1")] * 8))
    assert [path.name for path in client.home.runs.iterdir()] == [*ids]


def test_a_key_of_another_edit_or_of_a_training_is_refused(client: JobClient, scene: Path, tmp_path: Path) -> None:
    open_store(client.home).put_scene(scene, "studio")
    client.edit(EditRequest("studio", b"a list", key="k-1"))
    client.submit(ask(tmp_path, key="k-2"))
    for key in ("k-1", "k-2"):
        with pytest.raises(KeyReusedError, match=key):
            client.edit(EditRequest("studio", b"another list", key=key))


def test_a_deleted_job_is_gone_with_its_files_and_workflows(client: JobClient, submit: Callable[..., str]) -> None:
    gone, stays = submit(), submit()
    client.cancel(gone)
    client.delete(gone)
    assert client.get(gone) is None
    assert [path.name for path in client.home.runs.iterdir()] == [stays]
    assert trash(client.home) == []
    assert [one.workflow_id for one in client._queue.list_workflows()] == [f"{stays}:1"]


def test_an_unfinished_job_is_not_deleted(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    with pytest.raises(JobConflictError, match="cancel it"):
        client.delete(job_id)
    assert client.home.run(job_id).is_dir()


def test_a_job_whose_last_process_still_saves_is_not_deleted(client: JobClient, submit: Callable[..., str]) -> None:
    job_id = submit()
    client.cancel(job_id)
    with RunFolder(client.home.run(job_id)).exclusive(), pytest.raises(JobConflictError, match="still saves"):
        client.delete(job_id)
    assert client.get(job_id) is not None


def test_an_edit_is_queued_and_one_of_no_scene_leaves_nothing(client: JobClient, scene: Path) -> None:
    with pytest.raises(KeyError, match="studio"):
        client.edit(EditRequest("studio", b""))
    assert (client.list(), list(client.home.runs.iterdir())) == ([], [])
    open_store(client.home).put_scene(scene, "studio")
    job = client.get(client.edit(EditRequest("studio", b"a list")))
    assert job is not None
    assert (job.state, job.title) == (JobState.QUEUED, "Scene")
    assert client.ahead_of(job) == 0
