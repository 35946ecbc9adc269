from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_bytes import file_bytes


def test_a_file_is_read_whole(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"\0a\n")
    assert file_bytes(tmp_path / "x", "a file") == b"\0a\n"


def test_one_that_cannot_be_read_is_named_with_what_was_hoped_for(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        file_bytes(tmp_path / "x.splat", "a .splat file")
    assert str(caught.value) == f"{tmp_path}/x.splat: cannot be read (No such file or directory); give a .splat file"
