"""Homes of earlier software, opened by this one.

`tests/jobs/homes/form_1` was written by the last commit with tables of the form 1. `{HOME}` stands for its path. Its
jobs are one that has made a scene, one that waits in the queue, and one that was cancelled.
"""

from __future__ import annotations

import dataclasses
import shutil
import sqlite3
import subprocess
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa
from postgres_server import PostgresServer

from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.store_check import check_store
from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.home.schema_number import SCHEMA
from jobs.home.table_upgrades import add_what_is_missing, rename_columns
from jobs.queue.client import JobClient
from jobs.records.job import Job, JobState
from jobs.records.job_schema import job_rows
from jobs.records.job_table import metadata
from jobs.records.keys import KeyTable

OLD = Path(__file__).parents[1] / "homes" / "form_1"
DONE, QUEUED, CANCELLED = "done-ab442600", "waits-2c2599ca", "cancelled-551faa09"


@pytest.fixture
def home(home: Home) -> Home:
    """The home of earlier software, at this test's path."""
    shutil.copytree(OLD, home.folder)
    for file in (home.folder / "jobs.sql", *home.runs.glob("*/run.json")):
        file.write_text(file.read_text().replace("{HOME}", str(home.folder)))
    with closing(sqlite3.connect(home.folder / "jobs.sqlite")) as database:
        database.executescript((home.folder / "jobs.sql").read_text())
    return home


def test_everything_of_an_earlier_home_is_there(home: Home) -> None:
    with JobClient(home) as client:
        jobs = {job.id: (job.state, job.title, job.labels, job.scene_id, job.ends) for job in client.list()}
        assert jobs == {
            DONE: (JobState.SUCCEEDED, "Done", ("old",), DONE, 0.0),
            QUEUED: (JobState.QUEUED, "Waits", ("old",), "", 0.0),
            CANCELLED: (JobState.CANCELLED, "Cancelled", ("old",), "", 0.0),
        }
        with client._engine.connect() as connection:
            assert connection.execute(sa.text("SELECT number FROM hgs_schema")).scalars().all() == [SCHEMA]
            found = {column["name"] for column in sa.inspect(connection).get_columns("hgs_job")}
            assert found == set(job_rows.c.keys())
    store = open_store(home)
    assert (check_store(store).scenes, check_store(store).sound, store.title(DONE)) == (1, True, "Renamed")
    with closing(KeyTable(home)) as keys:
        assert [key.name for key in keys.all()] == ["anna"]


def test_its_jobs_go_on(
    home: Home,
    client: JobClient,
    worker: Callable[..., subprocess.Popen[bytes]],
    wait_for: Callable[[str, Callable[[Job], bool], str], Job],
) -> None:
    client.retry(CANCELLED)
    worker()
    for job_id, attempt in ((QUEUED, 1), (CANCELLED, 2)):
        job = wait_for(job_id, lambda job: job.state.finished, "the end of the job")
        assert (job.state, job.attempt, job.error) == (JobState.SUCCEEDED, attempt, "")
    assert {scene.id for scene in open_store(home).list_scenes()} == {DONE, QUEUED, CANCELLED}


def test_columns_and_indexes_that_are_missing_are_added(engine: sa.Engine) -> None:
    with engine.begin() as connection:
        connection.execute(sa.text("DROP INDEX ix_hgs_job_list"))
        connection.execute(sa.text("ALTER TABLE hgs_job DROP COLUMN audio"))
    add_what_is_missing(engine, metadata)
    inspector = sa.inspect(engine)
    assert {column["name"] for column in inspector.get_columns("hgs_job")} == set(job_rows.c.keys())
    assert "ix_hgs_job_list" in {index["name"] for index in inspector.get_indexes("hgs_job")}


def test_postgres_is_brought_up_to_date_as_well(server: PostgresServer, tmp_path: Path) -> None:
    there = dataclasses.replace(Home.at(tmp_path / "home"), database_url=server.new_database())
    engine = create_engine(there)
    try:
        prepare_database(there, engine, metadata)
        with engine.begin() as connection:
            connection.execute(sa.text("ALTER TABLE hgs_job RENAME COLUMN ends TO stage_ends"))
            connection.execute(sa.text("ALTER TABLE hgs_job DROP COLUMN webhook"))
        rename_columns(engine)
        add_what_is_missing(engine, metadata)
        found = {column["name"] for column in sa.inspect(engine).get_columns("hgs_job")}
    finally:
        engine.dispose()
    assert found == set(job_rows.c.keys())
