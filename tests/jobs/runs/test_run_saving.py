"""Saving while a stage runs, without the store, and after another process has taken the run."""

from __future__ import annotations

import asyncio
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import obstore
import pytest
from obstore.exceptions import GenericError
from obstore.store import MemoryStore, ObjectStore

from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import Done, StageOutcome, Waits
from jobs.runs import run_saving
from jobs.runs.run_saving import RunSaving
from jobs.runs.run_transfer import RunState
from jobs.runs.stored_run import RunHead, StoredRun

ATTEMPT = ("a", 1)


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> ObjectStore:
    store = MemoryStore()
    monkeypatch.setattr(run_saving, "open_object_store", lambda url: store)
    for name in ("LOOK", "AGAIN"):
        monkeypatch.setattr(run_saving, name, 0.01)
    return store


@pytest.fixture
def home(tmp_path: Path) -> Home:
    places = {"database_url": "postgresql://db/hgs", "store_url": "s3://bucket", "run_state": "store"}
    return dataclasses.replace(Home.at(tmp_path / "home"), **places)


@pytest.fixture
def saving(home: Home, store: ObjectStore, tmp_path: Path) -> RunSaving:
    submitted = tmp_path / "submitted"
    submitted.mkdir()
    (submitted / "run.json").write_text("{}")
    RunState(StoredRun(store, "runs/a"), submitted, 0).create()
    saving = RunSaving(home)
    saving.begin(ATTEMPT, 1)
    return saving


def head(store: ObjectStore) -> RunHead:
    found = StoredRun(store, "runs/a").head()
    assert found is not None
    return found


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not condition():
            await asyncio.sleep(0.01)


def test_a_checkpoint_is_saved_while_the_stage_runs(saving: RunSaving, home: Home, store: ObjectStore) -> None:
    async def stage() -> None:
        assert await saving.claim(ATTEMPT) == Done()
        async with saving.meanwhile(ATTEMPT, lambda: None):
            (home.run("a") / "checkpoint.pt").write_text("5")
            await until(lambda: "checkpoint.pt" in head(store).files)

    asyncio.run(stage())
    assert head(store).epoch == 1


def test_a_store_that_is_away_costs_no_training(
    saving: RunSaving, home: Home, store: ObjectStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    put, refused = obstore.put, []

    def away(*arguments: Any, **options: Any) -> Any:
        if len(refused) < 3:
            refused.append(1)
            raise GenericError("the store is away")
        return put(*arguments, **options)

    async def stage() -> None:
        await saving.claim(ATTEMPT)
        monkeypatch.setattr(obstore, "put", away)
        async with saving.meanwhile(ATTEMPT, lambda: None):
            (home.run("a") / "checkpoint.pt").write_text("5")
            await until(lambda: "checkpoint.pt" in head(store).files)

    asyncio.run(stage())
    assert len(refused) == 3


def test_the_end_of_a_stage_waits_for_the_store(saving: RunSaving, home: Home, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*arguments: Any, **options: Any) -> Any:
        raise GenericError("no answer")

    async def stage() -> StageOutcome:
        await saving.claim(ATTEMPT)
        (home.run("a") / "train.json").write_text("{}")
        monkeypatch.setattr(obstore, "put", away)
        return await saving.save(ATTEMPT)

    assert asyncio.run(stage()) == Waits("the store fails: no answer", Cause.STORE)


def test_a_worker_whose_run_was_taken_is_told(saving: RunSaving, home: Home, store: ObjectStore) -> None:
    told = []

    async def stage() -> StageOutcome:
        await saving.claim(ATTEMPT)
        RunState(StoredRun(store, "runs/a"), home.folder / "elsewhere", 2).claim()
        async with saving.meanwhile(ATTEMPT, lambda: told.append(1)):
            (home.run("a") / "checkpoint.pt").write_text("5")
            await until(lambda: bool(told))
        return await saving.save(ATTEMPT)

    assert asyncio.run(stage()) == Waits("another process has taken this run over")
    assert saving.taken(ATTEMPT)
    assert "checkpoint.pt" not in head(store).files


def test_what_people_look_at_is_kept_of_a_job_that_is_done(saving: RunSaving, home: Home, store: ObjectStore) -> None:
    async def stage() -> None:
        await saving.claim(ATTEMPT)
        for name in ("checkpoint.pt", "stage.log", "points.npz"):
            (home.run("a") / name).write_text(name)
        await saving.save(ATTEMPT)

    asyncio.run(stage())
    saving.complete(ATTEMPT)
    assert set(head(store).files) == {"run.json", "stage.log"}
    assert head(store).complete


def test_a_worker_that_ends_saves_what_it_has(saving: RunSaving, home: Home, store: ObjectStore) -> None:
    asyncio.run(saving.claim(ATTEMPT))
    (home.run("a") / "checkpoint.pt").write_text("5")
    saving.save_all(60)
    assert "checkpoint.pt" in head(store).files


def test_the_capture_is_known_before_the_run_is_fetched(saving: RunSaving, store: ObjectStore, tmp_path: Path) -> None:
    assert saving.path_of_capture(ATTEMPT) is None  # run.json does not tell
    captures = (("b", "/captures/studio", False), ("c", "upload:studio", False), ("d", "/elsewhere/source/x", True))
    for job_id, capture, edited in captures:
        (tmp_path / "submitted" / "run.json").write_text(json.dumps({"capture": capture, "edited": edited}))
        RunState(StoredRun(store, f"runs/{job_id}"), tmp_path / "submitted", 0).create()
        saving.begin((job_id, 1), 1)
    assert saving.path_of_capture(("b", 1)) == Path("/captures/studio")
    assert saving.path_of_capture(("c", 1)) is None
    assert saving.path_of_capture(("d", 1)) is None  # comes with the run


def test_a_shared_home_needs_none_of_it(tmp_path: Path) -> None:
    saving = RunSaving(Home.at(tmp_path))
    saving.begin(ATTEMPT, 1)

    async def stage() -> None:
        assert await saving.claim(ATTEMPT) == Done()
        async with saving.meanwhile(ATTEMPT, lambda: None):
            pass
        assert await saving.save(ATTEMPT) == Done()

    asyncio.run(stage())
    saving.complete(ATTEMPT)
    assert list(tmp_path.iterdir()) == []


def test_the_scene_of_an_edit_comes_with_its_run(
    saving: RunSaving, home: Home, store: ObjectStore, tmp_path: Path
) -> None:
    source = tmp_path / "submitted" / "source" / "studio"  # another machine
    source.mkdir(parents=True)
    (source / "manifest.json").write_text("{}")
    spec = {"capture": str(source), "edited": True}
    (tmp_path / "submitted" / "run.json").write_text(json.dumps(spec))
    RunState(StoredRun(store, "runs/e"), tmp_path / "submitted", 0).create()
    saving.begin(("e", 1), 1)
    assert asyncio.run(saving.claim(("e", 1))) == Done()
    here = saving.capture("e", source)
    assert here == home.run("e") / "source" / "studio"
    assert (here / "manifest.json").is_file()
