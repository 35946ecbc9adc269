"""Results of readers, kept within a size and a time."""

from __future__ import annotations

import os
from pathlib import Path

from server.captures.reading_cache import ReadingCache, files_mark


def test_the_earliest_go_when_the_size_is_reached() -> None:
    cache = ReadingCache[str](10)
    for key, size in (("a", 4), ("b", 4), ("a", 6), ("c", 4)):  # a is kept anew
        cache.keep(key, f"found {key}", size)
    assert [cache.get(key) for key in "abc"] == ["found a", None, "found c"]
    cache.keep("large", "too large", 11)
    assert [cache.get(key) for key in ("a", "c", "large")] == [None] * 3
    cache.keep("d", "found d", 10)
    assert cache.get("d") == "found d"


def test_a_result_holds_for_its_time_alone() -> None:
    cache = ReadingCache[str](10)
    cache.keep("ends", "found", seconds=-1.0)
    cache.keep("stays", "found", seconds=1000.0)
    assert (cache.get("ends"), cache.get("stays")) == (None, "found")


def test_a_mark_changes_with_names_sizes_and_times(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    file = tmp_path / "a" / "b" / "c"
    marks = [files_mark(tmp_path)]
    file.write_text("1")
    marks.append(files_mark(tmp_path))
    file.write_text("12")
    marks.append(files_mark(tmp_path))
    os.utime(file, (5, 5))
    marks.append(files_mark(tmp_path))
    file.rename(file.with_name("d"))
    marks.append(files_mark(tmp_path))
    assert len(set(marks)) == len(marks)
    assert files_mark(tmp_path) == marks[-1]
    assert files_mark(tmp_path / "missing") == files_mark(Path("nothing"))
