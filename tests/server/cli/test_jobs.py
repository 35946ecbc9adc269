"""`hgs jobs`, on the real queue of a home."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records.job_schema import job_rows
from server.cli import jobs, main


@pytest.fixture
def client(home: Path) -> Iterator[JobClient]:
    with JobClient(Home.at(home)) as client:
        yield client


@pytest.fixture
def submit(client: JobClient, n3dv: Path) -> Callable[..., str]:
    return lambda *labels: client.submit(JobRequest(n3dv, RunConfig(), "Three", labels=labels))


def test_jobs_are_listed_and_filtered(submit: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    first, second = submit("night"), submit()
    assert main(["jobs", "ls"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["JOB", second, first]
    assert (
        main(["jobs", "ls", "--label", "night", "--state", "queued", "--find", "THREE", "--since", "1h", "--json"]) == 0
    )
    assert [job["id"] for job in json.loads(capsys.readouterr().out)["jobs"]] == [first]


def test_a_long_list_comes_in_pages(
    submit: Callable[..., str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "PAGE", 2)
    ids = [submit() for _ in range(5)]
    for limit, count in ((3, 3), (100, 5)):
        assert main(["jobs", "ls", "--limit", str(limit), "--json"]) == 0
        assert [job["id"] for job in json.loads(capsys.readouterr().out)["jobs"]] == ids[::-1][:count]


def test_one_job_is_shown(submit: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    job_id = submit("night")
    assert main(["jobs", "show", job_id]) == 0
    assert "labels      night" in capsys.readouterr().out
    assert main(["jobs", "show", job_id, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["id"] == job_id


def test_the_end_of_the_log_is_printed(
    client: JobClient, submit: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    job_id = submit()
    (client.home.run(job_id) / "stage.log").write_text("one\ntwo\nthree\n")
    assert main(["jobs", "logs", job_id, "--lines", "2"]) == 0
    assert capsys.readouterr().out == "two\nthree\n"


def test_jobs_are_cancelled_retried_and_deleted(
    client: JobClient, submit: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    ids = [submit(), submit()]
    assert main(["jobs", "cancel", *ids]) == 0
    assert main(["jobs", "retry", ids[0]]) == 0
    assert [client.list()[k].state.value for k in (0, 1)] == ["queued", "cancelled"]
    assert main(["jobs", "delete", ids[1]]) == 0
    assert [path.name for path in client.home.runs.iterdir()] == [ids[0]]


@pytest.mark.parametrize(("state", "status"), [("succeeded", 0), ("failed", 1)])
def test_watching_ends_with_the_job(
    client: JobClient, submit: Callable[..., str], capsys: pytest.CaptureFixture[str], state: str, status: int
) -> None:
    job_id = submit()
    with client._engine.begin() as connection:
        connection.execute(sa.update(job_rows).values(state=state, error="out of memory"))
    assert main(["jobs", "watch", job_id]) == status
    assert ("out of memory" in capsys.readouterr().err) == (status == 1)


def test_workers_and_slots(client: JobClient, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["jobs", "workers"]) == 0
    assert "0 of 0 slots are in use" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["show", "nobody"], "no such job"),
        (["logs", "nobody"], "no such job"),
        (["cancel", "nobody"], "no such job"),
        (["ls", "--limit", "0"], "--limit"),
        (["ls", "--since", "soon"], "--since"),
        (["ls", "--label", "a b"], "label"),
        (["ls", "--to", "nowhere"], "nowhere"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["jobs", *arguments]) == 2
    told = capsys.readouterr().err
    assert word in told
    assert told.count("\n") == 1
