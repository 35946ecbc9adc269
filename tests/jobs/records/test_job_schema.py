from __future__ import annotations

from pathlib import Path

import sqlalchemy as sa

from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.records.job_schema import metadata


def test_a_table_of_an_earlier_version_gets_the_new_columns_and_indexes(tmp_path: Path) -> None:
    home = Home.at(tmp_path)
    engine = create_engine(home)
    prepare_database(home, engine, metadata)
    with engine.begin() as connection:
        for index in ("ix_hgs_job_request_key", "ix_hgs_job_list", "ix_hgs_job_capture"):
            connection.exec_driver_sql(f"DROP INDEX {index}")
        for column in ("labels", "request_key", "audio"):
            connection.exec_driver_sql(f"ALTER TABLE hgs_job DROP COLUMN {column}")
        connection.exec_driver_sql("DROP TABLE hgs_job_label")
    prepare_database(home, engine, metadata)
    found = sa.inspect(engine)
    assert {index["name"] for index in found.get_indexes("hgs_job")} >= {
        "ix_hgs_job_request_key",
        "ix_hgs_job_list",
        "ix_hgs_job_capture",
    }
    assert {column["name"] for column in found.get_columns("hgs_job")} >= {"labels", "request_key", "audio"}
    engine.dispose()
