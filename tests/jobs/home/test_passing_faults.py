from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import obstore
import pytest
from obstore.exceptions import BaseError

from hgs_core.base.errors import InputError
from jobs.home.object_store import open_object_store
from jobs.home.passing_faults import Cause, one_line, passing_fault


def reason_of(error: BaseException) -> str:
    fault = passing_fault(error)
    assert fault is not None
    return fault.reason


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.ESTALE, errno.EROFS, errno.ECONNREFUSED])
def test_the_disk_the_mounts_and_the_network_are_waited_for(code: int) -> None:
    assert reason_of(OSError(code, os.strerror(code), "/data/x")) == f"/data/x: {os.strerror(code)}"


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
    assert passing_fault(error) is None


def test_the_cause_counts_and_what_an_error_was_raised_in_place_of() -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    wrapped = InputError("points.npz", "cannot be written")
    wrapped.__cause__ = full
    assert reason_of(wrapped) == "No space left on device"
    hidden = RuntimeError("unexpected pos 704 vs 598")  # torch's error on a full disk
    hidden.__context__ = full
    assert reason_of(hidden) == "No space left on device"


def test_a_full_disk_is_seen_behind_what_libraries_raise() -> None:
    import torch

    with Path("/dev/full").open("wb", buffering=0) as file, pytest.raises((OSError, RuntimeError)) as raised:
        torch.save(torch.zeros(1_000_000), file)
    assert reason_of(raised.value) == "No space left on device"
    with Path("/dev/full").open("wb", buffering=0) as file, pytest.raises(OSError, match="No space left") as failed:
        np.savez(file, a=np.zeros(1_000_000))
    assert reason_of(failed.value) == "No space left on device"


def test_a_store_is_waited_for_in_one_short_line(tmp_path: Path) -> None:
    store = open_object_store(tmp_path.as_uri())
    (tmp_path / "chunks").touch()
    with pytest.raises(Exception, match="Debug source") as raised:
        obstore.put(store, "chunks/a", b"a", mode="create")
    fault = passing_fault(raised.value)
    assert fault is not None
    assert fault.cause is Cause.STORE
    reason = fault.reason
    assert reason.startswith("the store fails: Generic LocalFileSystem error: ")
    assert "Debug source" not in reason


def test_how_long_a_store_did_not_answer_is_left_out() -> None:
    error = BaseError("Error performing HEAD http://127.0.0.1:9/a in 75.423µs - HTTP error")
    assert reason_of(error) == "the store fails: Error performing HEAD http://127.0.0.1:9/a - HTTP error"


def test_long_messages_are_cut() -> None:
    assert one_line("a\n b") == "a b"
    assert one_line("first\n\nsecond") == "first"
    assert one_line("x" * 1000) == "x" * 198 + " …"


def test_an_error_with_words_of_its_own_keeps_them() -> None:
    assert (
        reason_of(OSError(errno.ENOSPC, "2 GB are needed, 1 GB is free", "/data"))
        == "/data: 2 GB are needed, 1 GB is free"
    )
