"""Bounds and encodings of the text files of a capture."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.files import text_file
from hgs_core.capture.files.text_file import LONGEST_LINE, begins_with, read_json, read_text, read_toml, text_lines

TEXT = '{"ä": [1, 2.5],\n "b": "ß"}\n'


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_unicode_is_read_with_or_without_a_mark_and_any_ends_of_lines(
    tmp_path: Path, encoding: str, ending: str
) -> None:
    file = tmp_path / "a.json"
    file.write_bytes(TEXT.replace("\n", ending).encode(encoding))
    assert read_text(file, "mend it") == TEXT
    assert list(text_lines(file, "mend it")) == TEXT.splitlines()
    assert read_json(file, "mend it") == {"ä": [1, 2.5], "b": "ß"}
    assert begins_with(file, '{"ä"')


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"\xff\xfe\0\0a\0\0\0", "is UTF-32, which is not read; save it as UTF-8"),
        (
            "[1]".encode("utf-16-le"),
            "holds NUL bytes: it is no text, or UTF-16 without a byte order mark; save it as UTF-8",
        ),
        (b'"\xe4"', r"is not UTF-8 \(byte 1 is 0xe4: .*\); save it as UTF-8"),
        (b'{"a": 1, "a": 2}', "'a' is there twice in one object.*; mend it"),
        (b"[" * 100_000, "nested too deep to be read; mend it"),
        (b'{"a":' * 100_000, "nested too deep to be read; mend it"),
        (b"[1", "unreadable .*; mend it"),
    ],
)
def test_what_is_no_text_or_no_json_is_named_with_a_cure(tmp_path: Path, data: bytes, problem: str) -> None:
    (tmp_path / "a.json").write_bytes(data)
    with pytest.raises(InputError, match=rf"a\.json: .*{problem}"):
        read_json(tmp_path / "a.json", "mend it")


def test_long_whole_numbers_become_floats(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(f"[{'9' * 18}, 1{'0' * 20}, -1{'0' * 5000}]")
    assert read_json(tmp_path / "a.json", "") == [999_999_999_999_999_999, 1e20, float("-inf")]


@pytest.mark.parametrize("data", ["a = " + "[" * 100_000, "[a" + ".a" * 100_000 + "]\nb = 1", "a" + ".a" * 50 + " = 1"])
def test_toml_nested_too_deep_is_refused(tmp_path: Path, data: str) -> None:
    (tmp_path / "a.toml").write_text(data)
    with pytest.raises(InputError, match=r"a\.toml: its lists or tables are nested too deep"):
        read_toml(tmp_path / "a.toml", "mend it")


def test_rows_of_numbers_in_toml_are_no_deep_keys(tmp_path: Path) -> None:
    rows = ",\n".join(f"[{', '.join(['0.5'] * 50)}]" for _ in range(3))
    (tmp_path / "a.toml").write_text(f"a.b = [\n{rows}\n]\n")
    assert len(read_toml(tmp_path / "a.toml", "")["a"]["b"]) == 3


def test_a_large_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    """60 MB of JSON cost 440 MB once; files with holes take no room on disk."""
    file = tmp_path / "a.json"
    with file.open("wb") as opened:
        opened.truncate(60 << 20)
    tracemalloc.start()
    with pytest.raises(InputError, match=rf"a\.json: has {60 << 20} bytes, and {32 << 20} are the most that are read"):
        read_json(file, "mend it")
    with pytest.raises(InputError, match=rf"has {60 << 20} bytes, and {4 << 20} are the most"):
        read_text(file, "mend it")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 80 << 20  # the bytes that were read


@pytest.mark.parametrize("value", ["[]", "{}", "1.5"])
def test_many_small_values_are_counted_before_they_are_parsed(tmp_path: Path, value: str) -> None:
    file = tmp_path / "a.json"
    file.write_text("[" + ",".join([value] * 1_100_000) + "]")
    tracemalloc.start()
    with pytest.raises(InputError, match="values, and 1000000 are the most that are read; name each camera once"):
        read_json(file, "mend it")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 40 << 20


def test_values_within_the_bound_take_no_more_than_is_stated(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text("[" + ",".join(['{"a":1}'] * 60_000) + "]")  # 120,000 values of the million, 300 MB for all
    tracemalloc.start()
    assert len(read_json(file, "mend it")) == 60_000
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 300e6 * 0.12


def test_lines_are_cut_and_counted_without_the_whole_file_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.txt"
    file.write_text("a" * 5_000_000 + "\nb\n" + "c" * LONGEST_LINE + "\nd")
    tracemalloc.start()
    assert [(len(line), line[0]) for line in text_lines(file, "")] == [
        (LONGEST_LINE, "a"),
        (1, "b"),
        (LONGEST_LINE, "c"),
        (1, "d"),
    ]
    assert tracemalloc.get_traced_memory()[1] < 2 << 20
    tracemalloc.stop()
    monkeypatch.setattr(text_file, "_MOST_BYTES_BY_LINE", 1000)
    with pytest.raises(InputError, match="1000 are the most that are read; cut it"):
        next(text_lines(file, "cut it"))


def test_what_is_not_there_or_may_not_be_read_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone\.json: unreadable \(No such file"):
        read_json(tmp_path / "gone.json", "restore it")
    assert not begins_with(tmp_path / "gone.json", "{")


def test_json_of_a_usual_capture_is_far_below_the_bounds(tmp_path: Path) -> None:
    frame = {"file_path": "images/cam00/000000.png", "time": 0.0333, "transform_matrix": [[0.123456789] * 4] * 4}
    (tmp_path / "a.json").write_text(json.dumps({"frames": [frame] * 5_000}))
    assert len(read_json(tmp_path / "a.json", "")["frames"]) == 5_000
