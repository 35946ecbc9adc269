from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from hgs_core.base.errors import InputError
from jobs.home import schema_number
from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.records.job_schema import job_rows
from jobs.records.job_table import metadata


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[sa.Engine]:
    engine = create_engine(Home.at(tmp_path))
    prepare_database(Home.at(tmp_path), engine, metadata)
    yield engine
    engine.dispose()


def number(engine: sa.Engine) -> list[int]:
    with engine.connect() as connection:
        return list(connection.execute(sa.text("SELECT number FROM hgs_schema")).scalars())


def test_older_software_leaves_a_newer_database_alone(
    engine: sa.Engine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(schema_number, "SCHEMA", schema_number.SCHEMA + 1)
    prepare_database(Home.at(tmp_path), engine, metadata)
    newer = number(engine)
    monkeypatch.undo()
    with engine.begin() as connection:
        connection.execute(sa.text("DROP TABLE hgs_worker"))  # it would make it anew
    with pytest.raises(InputError, match=r"has tables of the form 3, and HGS .* knows them up to 2; install"):
        prepare_database(Home.at(tmp_path), engine, metadata)
    assert number(engine) == newer
    assert not sa.inspect(engine).has_table("hgs_worker")


def test_newer_software_takes_an_older_database_over(
    engine: sa.Engine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with engine.begin() as connection:
        connection.execute(sa.text("DROP TABLE hgs_schema"))  # a database without a number
    prepare_database(Home.at(tmp_path), engine, metadata)
    assert number(engine) == [schema_number.SCHEMA]
    monkeypatch.setattr(schema_number, "SCHEMA", 7)
    prepare_database(Home.at(tmp_path), engine, metadata)
    assert number(engine) == [7]


COLUMNS = """
id title capture config state attempt epoch stage done total figures error scene_id waiting cause created updated labels
priority time_limit ends webhook audio request_key request_digest
"""
"""The columns of jobs in the tables of the form 2. Where one of them is gone or renamed, workers of this form fail."""


def test_a_column_that_is_gone_needs_a_new_number() -> None:
    assert schema_number.SCHEMA > 2 or set(COLUMNS.split()) <= set(job_rows.c.keys())
