from __future__ import annotations

from pathlib import Path

import pytest

import jobs.worker
from jobs.home.home import Home
from server.cli import main


def test_the_home_is_that_of_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The worker itself is tested as a process in tests/jobs/test_worker.py."""
    served: list[Home] = []

    def run_worker(home: Home) -> None:
        served.append(home)
        raise SystemExit(0)  # the end of a worker

    monkeypatch.setattr(jobs.worker, "run_worker", run_worker)
    monkeypatch.setenv("HGS_HOME", str(tmp_path / "home"))
    with pytest.raises(SystemExit):
        main(["worker"])
    assert [home.folder for home in served] == [tmp_path / "home"]
