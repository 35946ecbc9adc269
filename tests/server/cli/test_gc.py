from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.runs.config import RunConfig
from jobs.client import JobClient
from jobs.home import Home
from jobs.job_request import JobRequest
from server.cli import main


def test_nothing_is_changed_until_it_is_said(n3dv: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with JobClient(Home.at(home)) as client:
        job_id = client.submit(JobRequest(n3dv, RunConfig()))
        client.cancel(job_id)
        assert main(["gc", "--keep-jobs", "0"]) == 0
        told = capsys.readouterr().out
        assert job_id in told
        assert "nothing was changed" in told
        assert client.home.run(job_id).is_dir()
        assert main(["gc", "--keep-jobs", "0", "--delete", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["jobs"] == [job_id]
        assert not client.home.run(job_id).exists()


@pytest.mark.parametrize("option", ["--keep-jobs", "--keep-days", "--keep-bytes", "--every"])
def test_what_is_no_number_is_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gc", option, "many"]) == 2
    assert option in capsys.readouterr().err
