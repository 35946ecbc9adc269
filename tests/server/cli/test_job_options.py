from __future__ import annotations

from pathlib import Path

import pytest

from jobs.home.home import Home
from jobs.queue.client import JobClient
from server.cli import main


def test_the_options_of_a_job_reach_the_queue(n3dv: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--label", "night", "--label", "acme", "--priority", "5", "--time-limit", "12h", "--key", "k-1"]
    for _ in range(2):
        assert main(["submit", str(n3dv), *options]) == 0
    first, second = capsys.readouterr().out.split()
    assert first == second  # the key makes it one job
    with JobClient(Home.at(home)) as client:
        job = client.get(first)
    assert job is not None
    assert (job.labels, job.priority, job.time_limit) == (("night", "acme"), 5, 43200.0)


def test_a_limit_that_is_no_duration_is_refused(n3dv: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["submit", str(n3dv), "--time-limit", "long"]) == 2
    assert "--time-limit" in capsys.readouterr().err
