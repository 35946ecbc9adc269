from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes, StageSeconds


def test_everything_lies_in_the_home_folder_by_default(tmp_path: Path) -> None:
    home = Home.from_environment({"HGS_HOME": str(tmp_path)})
    assert home == Home.at(tmp_path)
    assert home.database_url == f"sqlite:///{tmp_path}/jobs.sqlite"
    assert home.store_url == f"file://{tmp_path}/store"
    assert home.run("a") == tmp_path / "runs" / "a"


def test_urls_replace_the_database_and_the_store(tmp_path: Path) -> None:
    home = Home.from_environment(
        {"HGS_HOME": str(tmp_path), "HGS_DATABASE_URL": "postgresql://db/hgs", "HGS_STORE_URL": "s3://bucket/hgs"}
    )
    assert (home.database_url, home.store_url) == ("postgresql://db/hgs", "s3://bucket/hgs")


def test_a_store_given_as_a_path_becomes_a_file_url(tmp_path: Path) -> None:
    assert Home.from_environment({"HGS_STORE_URL": str(tmp_path)}).store_url == f"file://{tmp_path}"


def test_empty_variables_count_as_absent(tmp_path: Path) -> None:
    assert Home.from_environment({"HGS_HOME": "", "HGS_STORE_URL": ""}) == Home.at(Path("~/.hgs"))


def test_a_child_process_reads_the_same_home(tmp_path: Path) -> None:
    limits = StageLimits(StageSeconds(90.0, (("train", 7.5),)), memory=StageBytes(8e9))
    home = Home(tmp_path, "postgresql://db/hgs", "s3://bucket/hgs", "another.pipeline", limits, 5e9, "store")
    assert Home.from_environment(home.environment()) == home


@pytest.mark.parametrize(
    ("environment", "problem"),
    [
        ({"HGS_RUN_STATE": "nfs"}, "HGS_RUN_STATE: 'nfs' is not one of home, store"),
        ({"HGS_RUN_STATE": "store"}, "HGS_RUN_STATE: store takes an object store, and the store is a folder"),
        ({"HGS_RUN_STATE": "store", "HGS_STORE_URL": "s3://bucket"}, "HGS_RUN_STATE: store takes Postgres"),
    ],
)
def test_the_state_of_runs_lies_where_it_can(environment: dict[str, str], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        Home.from_environment(environment)
    assert not Home.from_environment({}).runs_in_store
