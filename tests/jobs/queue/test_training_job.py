from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.job_request import JobRequest
from jobs.queue.training_job import make_training_job


def test_the_run_is_begun_with_what_was_given(home: Home, tmp_path: Path) -> None:
    given = GivenFiles(tmp_path / "masks", audio="none")
    begun: list[tuple[Path, Path, GivenFiles]] = []

    def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
        begun.append((run, capture, given))
        return config.changed({"seed": 5})

    job = make_training_job(home, JobRequest(tmp_path / "studio", RunConfig(), given=given), create_run)
    assert begun == [(home.run(job.id), tmp_path / "studio", given)]
    assert (job.title, job.audio, job.config["seed"]) == ("studio", "none", 5)


def test_a_run_that_cannot_be_begun_leaves_nothing(home: Home, tmp_path: Path) -> None:
    def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles) -> RunConfig:
        run.mkdir(parents=True)
        raise InputError(capture, "is damaged")

    with pytest.raises(InputError, match="is damaged"):
        make_training_job(home, JobRequest(tmp_path, RunConfig()), create_run)
    assert not any(home.runs.iterdir())
