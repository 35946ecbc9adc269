"""Two machines that make the segments of one run, and share a store."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from pathlib import Path

import obstore
import pytest
import segment_pipeline
from obstore.exceptions import GenericError
from obstore.store import MemoryStore, ObjectStore

from hgs_core.base.progress import Progress, StageStopped, silent
from jobs.home.home import Home
from jobs.runs import shared_segments as segments
from jobs.runs import stored_segments
from jobs.runs.run_transfer import RunState
from jobs.runs.shared_segments import help_with_segment, make_segments
from jobs.runs.stored_run import RunTakenError, StoredRun
from jobs.runs.stored_segments import StoredSegments, is_of_segment

Machine = Callable[[str], tuple[Path, StoredSegments]]


@pytest.fixture
def store() -> ObjectStore:
    return MemoryStore()


@pytest.fixture
def machine(store: ObjectStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    """Return a function: name -> the folder of a run of three segments, the first one made, and its sharing."""
    monkeypatch.setattr(stored_segments, "LOOK", 0.0)
    monkeypatch.setattr(segments, "LOOK", 0.01)

    def machine(name: str) -> tuple[Path, StoredSegments]:
        run = tmp_path / name
        (run / "segments").mkdir(parents=True)
        (run / "run.json").write_text(json.dumps({"segments": 3, "pace": 0, "iterations": 4}))
        segment_pipeline.make_segment(run, 0, silent)
        return run, StoredSegments(store, "a", run, segment_pipeline, lambda: None)

    return machine


def made(run: Path) -> list[str]:
    return [line.split()[0] for line in (run / "made.log").read_text().splitlines()]


def nothing() -> None: ...


def test_what_a_helper_made_comes_to_the_one_who_has_the_job(machine: Machine) -> None:
    (one, own), (two, helps) = machine("one"), machine("two")
    help_with_segment(segment_pipeline, two, silent, nothing, helps)
    assert made(two) == ["0", "1"]
    shown = []
    make_segments(segment_pipeline, one, silent, lambda: shown.append(1), own)
    assert made(one) == ["0", "2"]
    assert len(shown) == 2
    assert "live" not in json.loads((one / "scene" / "manifest.json").read_text())
    assert not (two / "scene").exists()


def test_a_segment_that_another_makes_is_left_to_it(machine: Machine) -> None:
    (one, own), (_, helps) = machine("one"), machine("two")
    with helps.claimed(1, nothing) as claimed:
        assert claimed
        with own.claimed(1, nothing) as again:
            assert not again
        help_with_segment(segment_pipeline, one, silent, nothing, own)
    assert made(one) == ["0", "2"]


def test_one_that_was_given_up_goes_on_from_its_checkpoint(machine: Machine) -> None:
    (one, own), (two, helps) = machine("one"), machine("two")

    def stop(progress: Progress) -> None:
        if progress.done == 2:
            raise StageStopped

    with pytest.raises(StageStopped):
        help_with_segment(segment_pipeline, two, stop, nothing, helps)
    make_segments(segment_pipeline, one, silent, nothing, own)
    steps = (one / "iterations.log").read_text().splitlines()
    assert steps[4:] == ["1 2", "1 3", "2 0", "2 1", "2 2", "2 3"]


def test_who_is_silent_for_long_counts_as_dead_and_learns_it(
    machine: Machine, store: ObjectStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    (_, own), (two, _) = machine("one"), machine("two")
    speaks, lost = threading.Event(), threading.Event()
    save = RunState.save

    def silent_save(state: RunState, **options: bool) -> None:
        speaks.wait(60)
        save(state, **options)

    monkeypatch.setattr(stored_segments, "BEAT", 0.01)
    monkeypatch.setattr(stored_segments, "SEGMENT_SILENCE", 0.0)
    monkeypatch.setattr(RunState, "save", silent_save)
    silenced = StoredSegments(store, "a", two, segment_pipeline, lost.set)
    claim = silenced.claimed(1, nothing)
    assert claim.__enter__()
    own.bring()
    with own.claimed(1, nothing) as taken:
        assert taken
        speaks.set()
        assert lost.wait(60)
        with pytest.raises(RunTakenError):
            claim.__exit__(None, None, None)


def test_the_store_away_is_not_the_others_silence(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    (_, own), (_, helps) = machine("one"), machine("two")
    monkeypatch.setattr(stored_segments, "SEGMENT_SILENCE", 0.0)
    get = obstore.get

    def away(*arguments: object) -> None:
        raise GenericError("no answer")

    with helps.claimed(1, nothing) as claimed:
        assert claimed
        own.bring()
        monkeypatch.setattr(obstore, "get", away)
        assert not own.bring()
        with own.claimed(1, nothing) as taken:
            assert not taken
        monkeypatch.setattr(obstore, "get", get)
        with own.claimed(1, nothing) as taken:  # it has to be watched anew
            assert not taken


def test_files_of_segments_are_told_from_those_of_the_run(machine: Machine, tmp_path: Path) -> None:
    run, _ = machine("one")
    names = ["segments/0", "segments/1", "segments/12/chunks/a", "segments/1.checkpoint", "checkpoint-3.pt"]
    others = ["checkpoint.pt", "segments/0/settings.json", "scene.npz"]
    assert [name for name in names + others if is_of_segment(run, name)] == names[1:]
    assert not is_of_segment(tmp_path / "trained whole", "checkpoint-3.pt")


@pytest.fixture
def with_inputs(store: ObjectStore, tmp_path: Path) -> Path:
    """The run as it lies in the store, with inputs of three segments."""
    folder = tmp_path / "initialised"
    for name in ("run.json", "masks/0.masks", "masks/1.masks", "masks/2.masks", "points/1.npz", "points/static.npz"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)
    (folder / "run.json").write_text(json.dumps({"capture": "/videos", "without_capture": True}))
    RunState(StoredRun(store, "runs/a"), folder, 1).create()
    return folder


def test_the_inputs_of_one_segment_come_with_its_claim(machine: Machine, with_inputs: Path) -> None:
    run, helps = machine("two")
    with helps.claimed(1, nothing) as claimed:
        assert claimed
        brought = [path.relative_to(run).as_posix() for kind in ("masks", "points") for path in (run / kind).iterdir()]
        assert sorted(brought) == ["masks/1.masks", "points/1.npz"]
        assert (run / "points/1.npz").read_text() == "points/1.npz"


def test_a_helper_begins_without_the_inputs_of_single_segments(
    with_inputs: Path, store: ObjectStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stored_segments, "open_object_store", lambda url: store)
    folder = tmp_path / "a#1"
    with stored_segments.fetch_for_help(Home.at(tmp_path / "home"), folder):
        assert sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.*")) == [
            "points/static.npz",
            "run.json",
        ]


def test_a_claim_whose_inputs_cannot_be_brought_is_given_up(
    machine: Machine, with_inputs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (_, own), (_, helps) = machine("one"), machine("two")

    def away(*arguments: object) -> None:
        raise GenericError("no answer")

    monkeypatch.setattr(stored_segments, "bring", away)
    with pytest.raises(GenericError), helps.claimed(1, nothing):
        pass
    monkeypatch.undo()
    with own.claimed(1, nothing) as claimed:
        assert claimed
