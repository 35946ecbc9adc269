from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from jobs.artifacts import ArtifactStore
from jobs.home_identity import FILE, HomeIdentity
from jobs.transient_faults import one_line, reason_to_wait, unreachable


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.ESTALE, errno.EROFS, errno.ECONNREFUSED])
def test_the_disk_the_mounts_and_the_network_are_waited_for(code: int) -> None:
    assert reason_to_wait(OSError(code, os.strerror(code), "/data/x")) == f"/data/x: {os.strerror(code)}"


@pytest.mark.parametrize(
    "error",
    [
        InputError("frame 3", "is missing"),
        FileNotFoundError(errno.ENOENT, "No such file or directory", "points.npz"),
        PermissionError(errno.EACCES, "Permission denied", "points.npz"),
        MemoryError(),
        RuntimeError("the loss is not a number"),
    ],
)
def test_failures_are_not(error: Exception) -> None:
    assert reason_to_wait(error) == ""


def test_the_cause_counts_and_what_an_error_was_raised_in_place_of() -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    wrapped = InputError("points.npz", "cannot be written")
    wrapped.__cause__ = full
    assert reason_to_wait(wrapped) == "No space left on device"
    hidden = RuntimeError("unexpected pos 704 vs 598")  # what torch makes of a full disk
    hidden.__context__ = full
    assert reason_to_wait(hidden) == "No space left on device"


def test_a_full_disk_is_seen_behind_what_libraries_raise() -> None:
    import torch

    with Path("/dev/full").open("wb", buffering=0) as file, pytest.raises((OSError, RuntimeError)) as raised:
        torch.save(torch.zeros(1_000_000), file)
    assert reason_to_wait(raised.value) == "No space left on device"
    with Path("/dev/full").open("wb", buffering=0) as file, pytest.raises(OSError, match="No space left") as failed:
        np.savez(file, a=np.zeros(1_000_000))
    assert reason_to_wait(failed.value) == "No space left on device"


def test_a_store_is_waited_for_in_one_short_line(tmp_path: Path) -> None:
    store = ArtifactStore(tmp_path.as_uri())
    (tmp_path / "chunks").touch()
    with pytest.raises(Exception, match="Debug source") as raised:
        store._create("chunks/a", b"a")
    reason = reason_to_wait(raised.value)
    assert reason.startswith("the store fails: Generic LocalFileSystem error: ")
    assert "Debug source" not in reason


def test_long_messages_are_cut() -> None:
    assert one_line("a\n b") == "a b"
    assert one_line("first\n\nsecond") == "first"
    assert one_line("x" * 1000) == "x" * 198 + " …"


class TestUnreachable:
    @pytest.fixture
    def home(self, tmp_path: Path) -> HomeIdentity:
        (tmp_path / FILE).write_text("1234")
        return HomeIdentity(tmp_path, "1234")

    def test_nothing_is_missing(self, home: HomeIdentity, tmp_path: Path) -> None:
        assert unreachable(home, tmp_path) == ""

    def test_the_home(self, home: HomeIdentity, tmp_path: Path) -> None:
        (tmp_path / FILE).unlink()
        assert "is not the home of this database" in unreachable(home, tmp_path)

    def test_the_capture(self, home: HomeIdentity, tmp_path: Path) -> None:
        reason = unreachable(home, tmp_path / "capture")
        assert reason == f"{tmp_path}/capture: the capture cannot be reached (No such file or directory)"

    def test_an_empty_mount_point(self, home: HomeIdentity, tmp_path: Path) -> None:
        (tmp_path / "capture").mkdir()
        assert unreachable(home, tmp_path / "capture").endswith("the capture's folder is empty; is it mounted?")

    def test_a_full_disk(self, home: HomeIdentity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("jobs.transient_faults.FULL", 1 << 80)
        assert unreachable(home, tmp_path) == f"{tmp_path}: No space left on device"
