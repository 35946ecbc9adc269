"""Homes, disks, stores and captures that are there, and that are not."""

from __future__ import annotations

import dataclasses
import errno
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from jobs.home.home import Home
from jobs.home.home_identity import FILE, HomeIdentity
from jobs.home.passing_faults import Cause
from jobs.runs import readiness
from jobs.runs.readiness import Surroundings


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    folder = tmp_path / "capture"
    folder.mkdir()
    (folder / "frame.jpg").touch()
    return folder


@pytest.fixture
def surroundings(home: Home) -> Surroundings:
    home.folder.mkdir()
    (home.folder / FILE).write_text("an id")
    return Surroundings(home, HomeIdentity(home.folder, "an id"))


def test_where_all_is_there_nothing_is_missing(surroundings: Surroundings, capture: Path) -> None:
    assert surroundings.of_job(capture) is None
    assert surroundings.of_machine() is None
    assert surroundings.store() is None
    for cause in (Cause.HOME, Cause.DISK, Cause.CAPTURE):
        assert surroundings.is_back(cause, capture)


def test_a_home_that_is_not_mounted(surroundings: Surroundings, home: Home, capture: Path) -> None:
    (home.folder / FILE).unlink()
    for missing in (surroundings.of_job(capture), surroundings.of_machine()):
        assert missing is not None
        assert missing.cause is Cause.HOME
        assert "is not the home of this database" in missing.reason
    assert not surroundings.is_back(Cause.HOME, capture)


def test_a_disk_that_is_full(surroundings: Surroundings, capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=4096))
    missing = surroundings.of_machine()
    assert missing is not None
    assert missing.cause is Cause.DISK
    assert missing.reason.endswith(": No space left on device")
    assert not surroundings.is_back(Cause.DISK, capture)


def test_a_home_whose_file_server_is_gone(
    surroundings: Surroundings, capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stale(folder: Path) -> None:
        raise OSError(errno.ESTALE, "Stale file handle")

    monkeypatch.setattr(shutil, "disk_usage", stale)
    missing = surroundings.of_job(capture)
    assert missing is not None
    assert missing.cause is Cause.HOME


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (shutil.rmtree, "the capture cannot be reached (No such file or directory)"),
        (lambda capture: (capture / "frame.jpg").unlink(), "the capture's folder is empty; is it mounted?"),
    ],
)
def test_a_capture_that_is_not_mounted(
    surroundings: Surroundings, capture: Path, change: Callable[[Path], object], reason: str
) -> None:
    change(capture)
    missing = surroundings.of_job(capture)
    assert missing is not None
    assert missing.cause is Cause.CAPTURE
    assert missing.reason == f"{capture}: {reason}"
    assert not surroundings.is_back(Cause.CAPTURE, capture)
    assert surroundings.of_machine() == missing  # another machine may see it


def test_a_capture_that_comes_back_is_missed_no_more(surroundings: Surroundings, capture: Path) -> None:
    (capture / "frame.jpg").unlink()
    surroundings.of_job(capture)
    (capture / "frame.jpg").touch()
    assert surroundings.of_machine() is None


def test_a_capture_that_stays_away_is_forgotten_after_a_while(
    surroundings: Surroundings, capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (capture / "frame.jpg").unlink()
    surroundings.of_job(capture)
    monkeypatch.setattr(readiness, "CAPTURE_BACKOFF", 0.0)
    assert surroundings.of_machine() is None  # other jobs can be taken


class TestStore:
    @pytest.fixture
    def surroundings(self, home: Home, monkeypatch: pytest.MonkeyPatch) -> Surroundings:
        """The store is a server that nobody is at."""
        for name, value in {"ENDPOINT": "http://127.0.0.1:9", "ALLOW_HTTP": "true", "REGION": "here"}.items():
            monkeypatch.setenv(f"AWS_{name}", value)
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            monkeypatch.setenv(name, "test")
        home.folder.mkdir()
        (home.folder / FILE).write_text("an id")
        return Surroundings(dataclasses.replace(home, store_url="s3://bucket/hgs"), HomeIdentity(home.folder, "an id"))

    def test_a_store_that_does_not_answer(self, surroundings: Surroundings) -> None:
        missing = surroundings.store()
        assert missing is not None
        assert missing.cause is Cause.STORE
        assert missing.reason.startswith("the store fails: Generic S3 error: ")

    def test_the_watch_tells_it_of_the_machine(
        self, surroundings: Surroundings, capture: Path, wait_until: Callable[[Callable[[], bool], str], None]
    ) -> None:
        assert not surroundings.is_back(Cause.STORE, capture)  # nobody has looked yet
        surroundings.watch_store()
        wait_until(lambda: surroundings.of_machine() is not None, "the first look")
        assert not surroundings.is_back(Cause.STORE, capture)
