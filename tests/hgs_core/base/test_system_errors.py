from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from hgs_core.base.system_errors import THE_OUTPUT, as_input_error


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES, errno.ENOTDIR, errno.ENAMETOOLONG, errno.EROFS])
def test_an_error_names_its_file_what_is_wrong_and_a_cure(number: int) -> None:
    told = as_input_error(OSError(number, os.strerror(number), "/some/file"))
    assert told.where == "/some/file"
    assert told.problem.lower() == os.strerror(number).lower()
    assert told.cure


def test_an_error_without_a_file_takes_the_one_that_was_meant() -> None:
    nameless = OSError(errno.ENOSPC, "No space left on device")
    assert as_input_error(nameless, Path("a.npz")).where == "a.npz"
    assert as_input_error(nameless).where == THE_OUTPUT


@pytest.mark.parametrize("error", [OSError(), OSError("only words"), OSError(99999, "unheard of", b"/bytes\xff")])
def test_any_error_is_one_line(error: OSError) -> None:
    line = str(as_input_error(error))
    assert line
    assert "\n" not in line
