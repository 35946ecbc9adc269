"""A job that runs, on a database of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.records.job import Job
from jobs.records.job_table import JobTable, metadata
from jobs.runs.readiness import Surroundings


@pytest.fixture
def home_engine(home: Home) -> Iterator[sa.Engine]:
    home_engine = create_engine(home)
    yield home_engine
    home_engine.dispose()


@pytest.fixture
def surroundings(home: Home, home_engine: sa.Engine) -> Surroundings:
    return Surroundings(home, prepare_database(home, home_engine, metadata))


@pytest.fixture
def table(home_engine: sa.Engine, surroundings: Surroundings, home: Home, tmp_path: Path) -> JobTable:
    """The table of jobs, with the job "a", which runs."""
    table = JobTable(home_engine)
    (tmp_path / "capture").mkdir()
    (tmp_path / "capture" / "frame.jpg").touch()
    home.run("a").mkdir(parents=True)
    with home_engine.begin() as connection:
        table.insert(connection, Job(id="a", title="A", capture=str(tmp_path / "capture"), config={}))
    table.start("a", 1)
    return table
