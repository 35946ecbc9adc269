"""A run in the object store: its head is replaced by conditional put, and damage is named."""

from __future__ import annotations

import io
from pathlib import Path

import obstore
import pytest
from obstore.store import MemoryStore, ObjectStore, from_url

from hgs_core.base.errors import InputError
from jobs.runs.stored_run import RunHead, RunTakenError, StoredRun


@pytest.fixture(params=["memory", "s3"])
def store(request: pytest.FixtureRequest) -> ObjectStore:
    return MemoryStore() if request.param == "memory" else from_url(request.getfixturevalue("s3_url"))


@pytest.fixture
def run(store: ObjectStore) -> StoredRun:
    return StoredRun(store, "runs/a")


def test_only_who_has_read_the_present_head_can_put_the_next(run: StoredRun) -> None:
    assert run.head() is None
    first = run.create(RunHead(0))
    second = run.replace(first, RunHead(1))
    assert run.head() == second
    with pytest.raises(RunTakenError, match="runs/a: another process has taken this run over"):
        run.replace(first, RunHead(2))
    assert run.head() == second
    assert run.replace(second, RunHead(2)).epoch == 2


def test_a_run_is_created_once(run: StoredRun) -> None:
    run.create(RunHead(0))
    with pytest.raises(RunTakenError):
        run.create(RunHead(5))


def test_the_same_head_put_twice_is_another_one(run: StoredRun) -> None:
    first = run.create(RunHead(0))
    second = run.replace(first, RunHead(0))
    with pytest.raises(RunTakenError):
        run.replace(first, RunHead(0))
    assert second.tag != first.tag


def test_a_put_whose_answer_was_lost_counts(run: StoredRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """The library repeats a request that has already succeeded, and is refused."""
    first = run.create(RunHead(0))
    put = obstore.put

    def twice(*arguments: object, **options: object) -> object:
        put(*arguments, **options)  # type: ignore[arg-type]
        return put(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(obstore, "put", twice)
    second = run.replace(first, RunHead(1))
    assert run.head() == second


def test_a_run_that_was_removed_is_lost(run: StoredRun) -> None:
    head = run.create(RunHead(0, {"run.json": run.put_bytes(0, b"a")}))
    run.remove()
    assert run.head() is None
    with pytest.raises(RunTakenError):
        run.replace(head, RunHead(1))


def test_a_content_that_is_known_is_not_put_again(run: StoredRun) -> None:
    first = run.put_file(1, io.BytesIO(b"checkpoint"))
    assert run.put_file(2, io.BytesIO(b"checkpoint"), first) == first
    assert run.put_file(2, io.BytesIO(b"another"), first).epoch == 2


def test_what_no_head_names_is_removed_but_not_what_a_later_epoch_puts(run: StoredRun, store: ObjectStore) -> None:
    old, kept, later = run.put_bytes(1, b"old"), run.put_bytes(1, b"kept"), run.put_bytes(3, b"later")
    part = StoredRun(store, "runs/a/parts/1").put_bytes(1, b"of a segment")
    run.remove_superseded(run.create(RunHead(2, {"checkpoint.pt": kept})))
    left = {item["path"] for page in obstore.list(store, prefix="runs/a") for item in page}
    names = {kept.name, later.name, f"parts/1/{part.name}", "head.json"}
    assert left == {f"runs/a/{name}" for name in names}
    assert old.name not in names


def test_a_download_goes_on_from_what_is_there(run: StoredRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = run.put_bytes(1, b"0123456789")
    (tmp_path / "part").write_bytes(b"0123")
    asked = []
    get = obstore.get

    def noted(*arguments: object, **options: object) -> object:
        asked.append(options["options"])
        return get(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(obstore, "get", noted)
    run.fetch(stored, tmp_path / "part")
    assert (tmp_path / "part").read_bytes() == b"0123456789"
    assert asked == [{"range": (4, 10)}]


def test_a_damaged_object_is_named(run: StoredRun, store: ObjectStore, tmp_path: Path) -> None:
    stored = run.put_bytes(1, b"right")
    obstore.put(store, f"runs/a/{stored.name}", b"wrong")
    with pytest.raises(InputError, match=f"the store's runs/a/{stored.name}: is damaged"):
        run.fetch(stored, tmp_path / "part")
    assert not (tmp_path / "part").exists()
    with pytest.raises(InputError, match="is damaged"):
        run.read(stored)


def test_a_damaged_head_is_named(run: StoredRun, store: ObjectStore) -> None:
    obstore.put(store, "runs/a/head.json", b'{"epoch": 1}')
    with pytest.raises(InputError, match=r"the store's runs/a/head.json: is damaged"):
        run.head()
