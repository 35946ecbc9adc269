"""Two machines and one run: the second resumes from the first one's state, and the first can save no more."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import obstore
import pytest
from obstore.store import MemoryStore, ObjectStore

from hgs_core.base.errors import InputError
from jobs.runs.capture_places import Translation
from jobs.runs.run_transfer import RunState, bring
from jobs.runs.stored_run import RunTakenError, StoredRun

State = Callable[..., RunState]


@pytest.fixture
def store() -> ObjectStore:
    return MemoryStore()


@pytest.fixture
def state(store: ObjectStore, tmp_path: Path) -> State:
    """Return a function: (machine, epoch) -> the run as that machine's worker has it, by default the submitted one."""
    (tmp_path / "submitted").mkdir()
    (tmp_path / "submitted" / "run.json").write_text("{}")
    RunState(StoredRun(store, "runs/a"), tmp_path / "submitted", 0).create()

    def state(machine: str, epoch: int) -> RunState:
        return RunState(StoredRun(store, "runs/a"), tmp_path / machine, epoch)

    return state


def test_another_machine_goes_on_from_what_was_saved(state: State, tmp_path: Path) -> None:
    first = state("one", 1)
    first.claim()
    (tmp_path / "one" / "checkpoint.pt").write_text("10")
    (tmp_path / "one" / "scene" / "chunks").mkdir(parents=True)
    (tmp_path / "one" / "scene" / "chunks" / "a").write_text("10")  # the same content under two names
    first.save()
    (tmp_path / "one" / "checkpoint.pt").write_text("15")  # and not saved
    (tmp_path / "two").mkdir()
    (tmp_path / "two" / "left.npz").write_text("of a time long ago")
    state("two", 2).claim()
    found = {path.relative_to(tmp_path / "two").as_posix() for path in (tmp_path / "two").rglob("*") if path.is_file()}
    assert found == {"run.json", "checkpoint.pt", "scene/chunks/a", ".epoch"}
    assert (tmp_path / "two" / "checkpoint.pt").read_text() == "10"


def test_files_are_brought_into_a_folder_that_is_not_there_yet(
    state: State, store: ObjectStore, tmp_path: Path
) -> None:
    first = state("one", 1)
    first.claim()
    (tmp_path / "one" / "train.json").write_text("10")
    first.save()
    stored = StoredRun(store, "runs/a")
    head = stored.head()
    assert head is not None
    bring(stored, {"train.json": head.files["train.json"]}, tmp_path / "new" / "run")
    assert (tmp_path / "new" / "run" / "train.json").read_text() == "10"


def test_who_had_the_run_before_can_save_no_more(state: State, tmp_path: Path) -> None:
    first, second = state("one", 1), state("two", 2)
    first.claim()
    second.claim()
    (tmp_path / "one" / "checkpoint.pt").write_text("10")
    with pytest.raises(RunTakenError):
        first.save()
    (tmp_path / "two" / "checkpoint.pt").write_text("5")
    second.save()
    state("three", 3).claim()
    assert (tmp_path / "three" / "checkpoint.pt").read_text() == "5"


def test_an_older_epoch_cannot_claim(state: State) -> None:
    state("two", 2).claim()
    with pytest.raises(RunTakenError, match="runs/a: epoch 2 has this run, not 1"):
        state("one", 1).claim()


def test_what_is_here_stays_if_nobody_else_had_the_run(state: State, tmp_path: Path) -> None:
    """A worker that is started again on its machine loses nothing that it had not saved."""
    first = state("one", 1)
    first.claim()
    (tmp_path / "one" / "checkpoint.pt").write_text("10")
    first.save()
    (tmp_path / "one" / "checkpoint.pt").write_text("15")
    again = state("one", 2)
    again.claim()
    assert (tmp_path / "one" / "checkpoint.pt").read_text() == "15"
    again.save()
    state("two", 3).claim()
    assert (tmp_path / "two" / "checkpoint.pt").read_text() == "15"


def test_a_claim_that_was_cut_off_is_no_claim(state: State, store: ObjectStore, tmp_path: Path) -> None:
    first = state("one", 1)
    first.claim()
    (tmp_path / "one" / "points.npz").write_text("points")
    first.save()
    head = StoredRun(store, "runs/a").head()
    assert head is not None
    content = f"runs/a/{head.files['points.npz'].name}"
    whole = bytes(obstore.get(store, content).bytes())
    obstore.put(store, content, b"damage")
    with pytest.raises(InputError, match="is damaged"):
        state("two", 2).claim()
    obstore.put(store, content, whole)
    state("two", 3).claim()  # it was the last one to have the run, but never had all of it
    assert (tmp_path / "two" / "points.npz").read_text() == "points"


def test_what_was_superseded_is_removed_from_the_store(state: State, store: ObjectStore, tmp_path: Path) -> None:
    first = state("one", 1)
    first.claim()
    for checkpoint in ("10", "20", "30"):
        (tmp_path / "one" / "checkpoint.pt").write_text(checkpoint)
        first.save()
    objects = [item["path"] for page in obstore.list(store, prefix="runs/a") for item in page]
    assert len(objects) == 3  # the head, run.json and one checkpoint


def test_locks_and_what_is_being_written_are_no_state(state: State, store: ObjectStore, tmp_path: Path) -> None:
    first = state("one", 1)
    first.claim()
    (tmp_path / "one" / "segments").mkdir()
    (tmp_path / "one" / ".pictures").mkdir()
    for name in (
        ".pictures/0.rgb",
        "run.lock",
        "run.lease.1",
        "segments/3.lock",
        ".scene.npz.ab.tmp",
        "x.tmp",
        "segments/3",
    ):
        (tmp_path / "one" / name).write_text(name)
    assert first.look() == ({"run.json", "segments/3"}, {"segments/3"})
    first.save()
    assert first.look()[1] == frozenset()
    head = StoredRun(store, "runs/a").head()
    assert head is not None
    assert set(head.files) == {"run.json", "segments/3"}


def test_a_save_of_nothing_new_puts_no_head_unless_it_is_a_sign_of_life(state: State, store: ObjectStore) -> None:
    first, run = state("one", 1), StoredRun(store, "runs/a")
    first.claim()
    before = run.head()
    first.save()
    assert run.head() == before
    first.save(always=True)
    assert run.head() != before
    first.save(free=True)
    assert (head := run.head()) is not None
    assert head.free


def test_run_json_names_the_capture_as_each_machine_sees_it(store: ObjectStore, tmp_path: Path) -> None:
    def state(machine: str, epoch: int) -> RunState:
        home = f"/{machine}"
        translation = Translation(lambda path: path.replace(home, "*"), lambda path: path.replace("*", home))
        return RunState(StoredRun(store, "runs/a"), tmp_path / machine, epoch, translate=translation)

    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "run.json").write_text(
        '{"capture": "/one/uploads/studio", "audio": "/one/uploads/studio/a.wav", "fingerprint": "x"}'
    )
    state("one", 0).create()
    state("two", 1).claim()
    spec = json.loads((tmp_path / "two" / "run.json").read_text())
    assert spec == {"capture": "/two/uploads/studio", "audio": "/two/uploads/studio/a.wav", "fingerprint": "x"}


def test_a_run_that_is_not_in_the_store_is_named(store: ObjectStore, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="runs/b: is not in the store"):
        RunState(StoredRun(store, "runs/b"), tmp_path / "b", 1).claim()
