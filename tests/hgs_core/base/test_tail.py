from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.tail import Tail, last_lines

FOUR = b"one\ntwo\nthree\nfour\n"


@pytest.mark.parametrize(
    ("data", "count", "most_bytes", "lines", "whole"),
    [
        (FOUR, 10, 100, ("one", "two", "three", "four"), True),
        (FOUR, 4, 100, ("one", "two", "three", "four"), True),
        (FOUR, 2, 100, ("three", "four"), False),
        (FOUR, 0, 100, (), False),
        (FOUR, 10, 8, ("four",), False),  # the first of the last eight bytes is in the middle of "three"
        (b"one\ntwo", 10, 100, ("one", "two"), True),
        (b"a long line", 10, 4, ("line",), False),
        (b"\xff\n", 10, 100, ("�",), True),
        (b"\n\n", 10, 100, ("", ""), True),
        (b"", 10, 100, (), True),
    ],
)
def test_last_lines(
    tmp_path: Path, data: bytes, count: int, most_bytes: int, lines: tuple[str, ...], whole: bool
) -> None:
    (tmp_path / "log").write_bytes(data)
    assert last_lines(tmp_path / "log", count, most_bytes) == Tail(lines, whole)


def test_a_file_that_is_not_there_has_no_lines(tmp_path: Path) -> None:
    assert last_lines(tmp_path / "log", 10, 100) == Tail()
