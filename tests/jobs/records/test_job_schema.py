from __future__ import annotations

from pathlib import Path

import sqlalchemy as sa

from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.records.job_schema import metadata


def test_a_new_database_has_the_indexes_that_the_list_of_jobs_needs(tmp_path: Path) -> None:
    engine = create_engine(Home.at(tmp_path))
    prepare_database(Home.at(tmp_path), engine, metadata)
    found = {index["name"] for index in sa.inspect(engine).get_indexes("hgs_job")}
    assert found >= {"ix_hgs_job_request_key", "ix_hgs_job_list", "ix_hgs_job_capture"}
    engine.dispose()
