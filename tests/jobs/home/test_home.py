from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.home.stage_settings import StageBytes, StageCount, StageSeconds


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


def test_the_silence_of_a_stage_is_a_positive_number(tmp_path: Path) -> None:
    assert Home.from_environment({"HGS_STAGE_SILENCE": "90"}).stage_silence == StageSeconds(90.0)
    assert Home.from_environment({"HGS_STAGE_REPORT": "90"}).stage_report == StageSeconds(90.0)
    for wrong in ("0", "-1", "nan", "inf", "soon"):
        with pytest.raises(InputError, match=f"HGS_STAGE_SILENCE: '{wrong}' is not a positive number of seconds"):
            Home.from_environment({"HGS_STAGE_SILENCE": wrong})


@pytest.mark.parametrize("name", ["HGS_STAGE_PROCESSES", "HGS_STAGE_FILES"])
def test_processes_and_files_of_a_stage_are_counted(name: str) -> None:
    field = name.removeprefix("HGS_").lower()
    assert getattr(Home.from_environment({name: "90,train=7"}), field) == StageCount(90, (("train", 7),))
    for wrong in ("0", "-1", "1.5", "many"):
        with pytest.raises(
            InputError, match=f"{name}: '{wrong}' is not a positive whole number; write one such as 256"
        ):
            Home.from_environment({name: wrong})


def test_the_longest_file_of_a_stage_has_bytes() -> None:
    assert Home.from_environment({"HGS_STAGE_FILE_SIZE": "5G"}).stage_file_size == StageBytes(5e9)
    with pytest.raises(InputError, match="HGS_STAGE_FILE_SIZE: 'large' is no number"):
        Home.from_environment({"HGS_STAGE_FILE_SIZE": "large"})


def test_a_child_process_reads_the_same_home(tmp_path: Path) -> None:
    seconds = StageSeconds(90.0, (("train", 7.5),))
    limits = (
        seconds,
        StageSeconds(0.5),
        StageBytes(8e9),
        StageCount(9),
        StageCount(8, (("train", 20),)),
        StageBytes(7.0),
    )
    home = Home(tmp_path, "postgresql://db/hgs", "s3://bucket/hgs", "another.pipeline", *limits, 5e9, "store")
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
