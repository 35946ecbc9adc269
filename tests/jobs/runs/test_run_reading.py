"""Runs of other machines, as the API shows them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import obstore
import pytest
from obstore.exceptions import GenericError
from obstore.store import MemoryStore, ObjectStore

from jobs.home.home import Home
from jobs.runs import run_reading
from jobs.runs.run_reading import RunReader, run_reader
from jobs.runs.run_transfer import RunState
from jobs.runs.stored_run import StoredRun


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> ObjectStore:
    store = MemoryStore()
    monkeypatch.setattr(run_reading, "open_object_store", lambda url, once: store)
    monkeypatch.setattr(run_reading, "FRESH", 0.0)
    return store


@pytest.fixture
def reader(store: ObjectStore, tmp_path: Path) -> RunReader:
    places = {"database_url": "postgresql://db/hgs", "store_url": "s3://bucket", "run_state": "store"}
    return run_reader(dataclasses.replace(Home.at(tmp_path / "api"), **places))


@pytest.fixture
def worker(store: ObjectStore, tmp_path: Path) -> RunState:
    """The run `a` in the folder `worker`."""
    run = tmp_path / "worker"
    (run / "scene").mkdir(parents=True)
    for name in ("run.json", "stage.log", "checkpoint.pt", "scene/thumbnail.jpg"):
        (run / name).write_text(name)
    RunState(StoredRun(store, "runs/a"), run, 0).create()
    worker = RunState(StoredRun(store, "runs/a"), run, 1)
    worker.claim()
    return worker


def test_what_people_look_at_is_copied_as_it_changes(reader: RunReader, worker: RunState, tmp_path: Path) -> None:
    folder = reader.folder("a")
    shown = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert shown == {"run.json", "stage.log", "scene/thumbnail.jpg"}
    (tmp_path / "worker" / "stage.log").write_text("more")
    (tmp_path / "worker" / "scene" / "thumbnail.jpg").unlink()
    worker.save()
    assert (reader.folder("a") / "stage.log").read_text() == "more"
    assert not (folder / "scene" / "thumbnail.jpg").exists()


def test_what_has_not_changed_is_not_fetched_again(
    reader: RunReader, worker: RunState, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (reader.folder("a") / "stage.log").stat().st_mtime_ns
    assert (reader.folder("a") / "stage.log").stat().st_mtime_ns == before


def test_while_the_store_is_away_the_copies_are_shown(
    reader: RunReader, worker: RunState, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader.folder("a")

    def away(*arguments: object) -> None:
        raise GenericError("no answer")

    monkeypatch.setattr(obstore, "get", away)
    assert (reader.folder("a") / "stage.log").read_text() == "stage.log"
    with pytest.raises(GenericError):
        reader.folder("b")


def test_a_run_that_is_not_there_has_nothing(reader: RunReader) -> None:
    assert not any(reader.folder("nobody").iterdir())


def test_no_more_than_some_copies_are_kept(
    reader: RunReader, worker: RunState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_reading, "MOST", 2)
    for name in ("a", "b", "c"):
        reader.folder(name)
    assert len(list((tmp_path / "api" / "shown").iterdir())) == 2
    assert (reader.folder("a") / "stage.log").exists()


def test_in_a_shared_home_the_run_itself_is_read(tmp_path: Path) -> None:
    assert run_reader(Home.at(tmp_path)).folder("a") == tmp_path / "runs" / "a"
