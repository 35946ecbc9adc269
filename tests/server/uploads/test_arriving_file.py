from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from server.http.problems import ProblemError
from server.uploads.arriving_file import ArrivingFile

CONTENT = bytes(range(256)) * 20


def arriving(folder: Path, content: bytes = CONTENT) -> ArrivingFile:
    return ArrivingFile(3, "cam00.mp4", len(content), hashlib.sha256(content).hexdigest(), folder)


def test_pieces_make_the_file(tmp_path: Path) -> None:
    file = arriving(tmp_path)
    for start in range(0, len(CONTENT), 1000):
        assert not file.verified
        file.append(file.begin(start), CONTENT[start : start + 1000])
    assert file.verified
    assert (tmp_path / "3").read_bytes() == CONTENT
    assert not (tmp_path / "3.part").exists()


def test_a_restart_goes_on_behind_what_is_on_disk(tmp_path: Path) -> None:
    before = arriving(tmp_path)
    before.append(before.begin(0), CONTENT[:3000])
    after = arriving(tmp_path)
    after.look()
    assert (after.offset, after.verified) == (3000, False)
    after.append(after.begin(3000), CONTENT[3000:])
    assert after.verified
    again = arriving(tmp_path)
    again.look()
    assert (again.offset, again.verified) == (len(CONTENT), True)


def test_a_restart_between_the_last_byte_and_the_hash_is_made_up_for(tmp_path: Path) -> None:
    (tmp_path / "3.part").write_bytes(CONTENT)
    file = arriving(tmp_path)
    file.look()
    assert not file.verified
    file.verify()
    assert file.verified


@pytest.mark.parametrize("restarted", [False, True])
def test_a_changed_byte_is_found_and_the_file_begins_anew(tmp_path: Path, restarted: bool) -> None:
    changed = bytearray(CONTENT)
    changed[17] ^= 1
    file = arriving(tmp_path)
    file.append(file.begin(0), bytes(changed[:3000]))
    if restarted:
        file = arriving(tmp_path)
        file.look()
    with pytest.raises(ProblemError, match="send it again") as caught:
        file.append(file.begin(3000), bytes(changed[3000:]))
    assert (caught.value.status, caught.value.code) == (422, "checksum-mismatch")
    assert (file.offset, file.verified, list(tmp_path.iterdir())) == (0, False, [])
    file.append(file.begin(0), CONTENT)
    assert file.verified


def test_another_offset_is_refused_with_the_right_one(tmp_path: Path) -> None:
    file = arriving(tmp_path)
    file.append(file.begin(0), CONTENT[:10])
    for offset in (0, 9, 11):
        with pytest.raises(ProblemError, match="has 10 bytes") as caught:
            file.begin(offset)
        assert caught.value.headers == {"Upload-Offset": "10"}


def test_who_comes_later_takes_over(tmp_path: Path) -> None:
    file = arriving(tmp_path)
    first = file.begin(0)
    file.append(first, CONTENT[:10])
    second = file.begin(10)
    with pytest.raises(ProblemError, match="another request sends this file"):
        file.append(first, CONTENT[10:20])
    file.append(second, CONTENT[10:])
    assert file.verified


def test_no_byte_more_than_announced_is_taken(tmp_path: Path) -> None:
    file = arriving(tmp_path)
    with pytest.raises(ProblemError, match="more bytes than"):
        file.append(file.begin(0), CONTENT + b"x")
    assert file.offset == 0


def test_an_empty_file_is_there_at_once(tmp_path: Path) -> None:
    file = arriving(tmp_path, b"")
    file.verify()
    assert (tmp_path / "3").read_bytes() == b""
