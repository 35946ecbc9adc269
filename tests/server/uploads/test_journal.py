from __future__ import annotations

from pathlib import Path

import pytest

from server.uploads.journal import FileJournal

FIRST = {"path": "cam00/0.jpg", "size": 3, "sha256": "a" * 64}
SECOND = {"path": "cam00/ö.jpg", "size": 0, "sha256": "b" * 64}


def test_what_was_added_is_read_in_order(tmp_path: Path) -> None:
    journal = FileJournal(tmp_path / "files.jsonl")
    assert journal.read() == []
    journal.add("cam00/0.jpg", 3, "a" * 64)
    journal.add("cam00/ö.jpg", 0, "b" * 64)
    assert FileJournal(tmp_path / "files.jsonl").read() == [FIRST, SECOND]


@pytest.mark.parametrize("torn", [b"{", b'{"path":"cam00/1.jpg","size":3'])
def test_a_line_that_was_cut_off_is_left_out_and_overwritten(tmp_path: Path, torn: bytes) -> None:
    file = tmp_path / "files.jsonl"
    journal = FileJournal(file)
    journal.add("cam00/0.jpg", 3, "a" * 64)
    with file.open("ab") as stream:
        stream.write(torn)
    assert journal.read() == [FIRST]
    journal.add("cam00/ö.jpg", 0, "b" * 64)
    assert journal.read() == [FIRST, SECOND]
