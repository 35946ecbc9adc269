"""Copies of runs on a worker's machine."""

from __future__ import annotations

import os
import time
from collections.abc import Collection
from pathlib import Path

import pytest

from hgs_core.runs.run_folder import RunFolder
from jobs.home.home import Home
from jobs.records.job import Job, JobState
from jobs.runs.run_removal import YOUNGEST, remove_copies


@pytest.fixture
def home(tmp_path: Path) -> Home:
    home = Home.at(tmp_path)
    for name in ("running", "done", "nobody", "young"):
        home.run(name).mkdir(parents=True)
        (home.run(name) / "checkpoint.pt").touch()
    before = time.time() - 2 * YOUNGEST
    os.utime(home.run("nobody"), (before, before))
    return home


def many(job_ids: Collection[str]) -> dict[str, Job]:
    states = {"running": JobState.RUNNING, "done": JobState.SUCCEEDED}
    return {name: Job(name, name, "/capture", {}, state) for name, state in states.items() if name in job_ids}


def test_those_of_finished_jobs_and_of_none_are_removed(home: Home) -> None:
    assert sorted(remove_copies(home, many)) == ["done", "nobody"]
    assert sorted(folder.name for folder in home.runs.iterdir()) == ["running", "young"]
    assert list((home.folder / "trash").iterdir()) == []


def test_one_that_a_process_works_on_stays(home: Home) -> None:
    with RunFolder(home.run("done")).exclusive():
        assert remove_copies(home, many) == ["nobody"]
    assert home.run("done").is_dir()
