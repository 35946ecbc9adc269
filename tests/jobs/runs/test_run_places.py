"""Places of runs: kept, counted and removed in a home and in a store; test_separate_homes.py has the rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from datetime import timedelta
from pathlib import Path

import obstore
import pytest
from obstore.store import MemoryStore, ObjectStore

from jobs.home.home import Home
from jobs.runs import run_places
from jobs.runs.run_places import RunPlace, RunsInHome, RunsInStore, run_place


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> ObjectStore:
    store = MemoryStore()
    monkeypatch.setattr(run_places, "open_object_store", lambda url: store)
    return store


@pytest.fixture(params=["home", "store"])
def home(request: pytest.FixtureRequest, tmp_path: Path) -> Home:
    places = {"database_url": "postgresql://db/hgs", "store_url": "s3://bucket", "run_state": request.param}
    return dataclasses.replace(Home.at(tmp_path), **places)


@pytest.fixture
def place(home: Home, store: ObjectStore) -> RunPlace:
    home.run("a").mkdir(parents=True)
    (home.run("a") / "run.json").write_text("{}")
    place = run_place(home)
    place.submitted("a")
    return place


def test_the_setting_decides(place: RunPlace, home: Home) -> None:
    assert isinstance(place, RunsInStore if home.runs_in_store else RunsInHome)
    assert home.run("a").exists() is not home.runs_in_store


def test_a_run_has_a_size_until_it_is_removed(place: RunPlace) -> None:
    sizes = place.sizes(["a", "b"])
    assert sizes["a"] >= 2
    assert sizes["b"] == 0
    place.remove("a")
    place.removed("a")
    assert place.sizes(["a"]) == {"a": 0}


def test_what_is_of_no_job_is_removed_from_the_store_once_it_is_old(
    store: ObjectStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = RunsInStore(Home.at(tmp_path))

    def nobody(job_ids: Collection[str]) -> list[str]:
        return []

    obstore.put(store, "runs/a/1/x", b"12345")
    assert place.left_over(nobody, delete=True) == 0
    monkeypatch.setattr(run_places, "_YOUNGEST", timedelta(hours=-1))
    assert place.left_over(list, delete=True) == 0  # there is such a job
    assert place.left_over(nobody, delete=False) == 5
    assert place.left_over(nobody, delete=True) == 5
    assert place.left_over(nobody, delete=True) == 0
