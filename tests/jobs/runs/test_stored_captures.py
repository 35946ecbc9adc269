"""Uploaded captures on machines that share no folder."""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path

import pytest
from obstore.store import MemoryStore, ObjectStore

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.runs import stored_captures
from jobs.runs.stored_captures import StoredCaptures, capture_of


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> ObjectStore:
    store = MemoryStore()
    monkeypatch.setattr(stored_captures, "open_object_store", lambda url: store)
    return store


def machine(folder: Path, most: float = 100.0) -> StoredCaptures:
    return StoredCaptures(dataclasses.replace(Home.at(folder), capture_cache=most))


@pytest.fixture
def here(store: ObjectStore, tmp_path: Path) -> StoredCaptures:
    """The machine that took the uploads `a`, `b` and `c`, of 30 bytes each."""
    for name in "abc":
        folder = tmp_path / "here" / "uploads" / "captures" / name
        (folder / "sparse").mkdir(parents=True)
        (folder / "cam00.mp4").write_bytes(b"video " * 4)
        (folder / "sparse" / "0.tmp").write_bytes(name.encode() * 6)
    here = machine(tmp_path / "here")
    for name in "abc":
        assert here.put(name, tmp_path / "here" / "uploads" / "captures" / name)
    return here


def test_a_run_names_it_as_each_machine_has_it(here: StoredCaptures, tmp_path: Path) -> None:
    path = str(tmp_path / "here" / "uploads" / "captures" / "a" / "take 1")
    assert here.portable(path) == "upload:a/take 1"
    assert here.local("upload:a/take 1") == path
    there = machine(tmp_path / "there")
    assert there.local("upload:a/take 1") == str(tmp_path / "there" / "fetched" / "a" / "take 1")
    assert there.portable(there.local("upload:a/take 1")) == "upload:a/take 1"
    assert there.local(there.portable("/captures/studio")) == "/captures/studio"
    for wrong in ("upload:../../etc", "upload:/etc", "upload:"):
        with pytest.raises(InputError, match="names the capture"):
            there.local(wrong)


def test_another_machine_fetches_it_once(here: StoredCaptures, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = machine(tmp_path / "there")
    path = Path(there.local("upload:a"))
    with there.held(path):
        assert (path / "cam00.mp4").read_bytes() == b"video " * 4
        assert (path / "sparse" / "0.tmp").read_bytes() == b"aaaaaa"
    monkeypatch.setattr(stored_captures, "bring", None)
    with there.held(path), here.held(Path(here.local("upload:a"))):
        pass


def test_a_download_that_was_cut_off_goes_on(
    here: StoredCaptures, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = machine(tmp_path / "there")
    part = tmp_path / "there" / "fetched" / ".a.part"
    part.mkdir(parents=True)
    (part / "cam00.mp4").write_bytes(b"video " * 4)
    brought = []
    bring = stored_captures.bring
    monkeypatch.setattr(
        stored_captures, "bring", lambda run, files, folder: (brought.extend(files), bring(run, files, folder))
    )
    with there.held(Path(there.local("upload:a"))):
        assert brought == ["sparse/0.tmp"]


def test_copies_take_no_more_room_than_they_may(here: StoredCaptures, tmp_path: Path) -> None:
    there = machine(tmp_path / "there", most=70.0)
    for time, name in enumerate("ab"):
        with there.held(Path(there.local(f"upload:{name}"))):
            pass
        os.utime(there.local(f"upload:{name}"), (time, time))
    with there.held(Path(there.local("upload:a"))):  # held: it stays, though unused for longer
        os.utime(there.local("upload:a"), (0, 0))
        with there.held(Path(there.local("upload:c"))):
            pass
    folders = {path.name for path in (tmp_path / "there" / "fetched").iterdir() if path.is_dir()}
    assert folders == {"a", "c"}


def test_a_name_is_of_one_capture(here: StoredCaptures, tmp_path: Path) -> None:
    assert here.put("a", tmp_path / "here" / "uploads" / "captures" / "a")
    assert not here.put("a", tmp_path / "here" / "uploads" / "captures" / "b")


def test_one_that_was_deleted_is_named(here: StoredCaptures, tmp_path: Path) -> None:
    here.remove("a")
    there = machine(tmp_path / "there")
    with pytest.raises(InputError, match="the upload 'a' was deleted"), there.held(Path(there.local("upload:a"))):
        pass


def test_a_run_that_edits_a_scene_has_its_copy(tmp_path: Path) -> None:
    for edited, expected in ((False, Path("/a/source/studio")), (True, tmp_path / "source" / "studio")):
        (tmp_path / "run.json").write_text(json.dumps({"capture": "/a/source/studio", "edited": edited}))
        assert capture_of(tmp_path) == expected
    (tmp_path / "run.json").write_text("[]")
    assert capture_of(tmp_path) is None
