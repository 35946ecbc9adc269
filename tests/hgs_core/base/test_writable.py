from __future__ import annotations

import os
import resource
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_file, require_writable_folder


@pytest.fixture
def full_disk() -> Iterator[None]:
    """No file may grow, as on a disk without a free block."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def test_a_place_that_can_be_written_is_left_as_it_was(tmp_path: Path) -> None:
    require_writable_folder(tmp_path / "a" / "b" / "c")
    require_writable_file(tmp_path / "d" / "file")
    (tmp_path / "old").write_bytes(b"old")
    require_writable_file(tmp_path / "old")
    require_writable_folder(tmp_path)
    assert [path.name for path in tmp_path.rglob("*")] == ["old"]
    assert (tmp_path / "old").read_bytes() == b"old"


@pytest.mark.parametrize(
    ("place", "problem"),
    [
        ("file/x", "not a directory"),
        ("n" * 300, "name too long"),
        ("loop/x", "symbolic links"),
        ("n/" * 3000, "too long"),
    ],
)
@pytest.mark.parametrize("require", [require_writable_file, require_writable_folder])
def test_a_place_that_cannot_be_had_is_named_with_the_cure(
    tmp_path: Path, place: str, problem: str, require: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to("loop")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError, match=rf"cannot be written \(.*{problem}.*\); ") as caught:
        require(tmp_path / place)
    assert caught.value.where == InputError(tmp_path / place, "").where
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.skipif(not Path("/sys").is_dir(), reason="Linux")
def test_a_file_system_that_takes_no_files_is_refused() -> None:
    with pytest.raises(InputError, match="/sys/x: cannot be written"):
        require_writable_folder(Path("/sys/x"))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_of_others_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="permission denied"):
        require_writable_folder(tmp_path / "x")
    tmp_path.chmod(0o700)


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_is_noticed_though_it_takes_an_empty_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be written \(file too large\)"):
        require_writable_folder(tmp_path / "x")
    assert list(tmp_path.iterdir()) == []


def test_a_device_is_not_replaced_by_a_file() -> None:
    with pytest.raises(InputError, match="is no regular file"):
        require_writable_file(Path("/dev/null"))
    assert Path("/dev/null").is_char_device()


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder; name a file"):
        require_writable_file(tmp_path)
