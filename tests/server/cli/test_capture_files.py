from __future__ import annotations

import hashlib
import os
import zipfile
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from server.cli.capture_files import capture_files, opened_capture, upload_key
from server.uploads.upload_limits import UploadLimits


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("studio/cam00.mp4", "studio/sparse/0/a.txt", "studio/.DS_Store", "studio/Thumbs.db", "studio/.git/x"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(name.encode())
    (tmp_path / "studio" / "linked.mp4").symlink_to(tmp_path / "studio" / "cam00.mp4")
    return tmp_path / "studio"


def test_the_files_of_a_folder_are_those_that_people_put_there(folder: Path) -> None:
    files = capture_files(folder)
    assert [(file.path, file.size) for file in files] == [("cam00.mp4", 16), ("linked.mp4", 16), ("sparse/0/a.txt", 21)]
    assert files[1].sha256() == hashlib.sha256(b"studio/cam00.mp4").hexdigest()


def test_the_key_is_that_of_the_document(folder: Path) -> None:
    lines = "cam00.mp4\t16\nlinked.mp4\t16\nsparse/0/a.txt\t21\n"
    assert upload_key(list(reversed(capture_files(folder)))) == hashlib.sha256(lines.encode()).hexdigest()


def test_what_cannot_be_sent_is_refused_by_name(folder: Path, tmp_path: Path) -> None:
    (folder / "loop").symlink_to(folder)
    with pytest.raises(InputError, match="loop: is no file, or a link to a folder"):
        capture_files(folder)
    (folder / "loop").unlink()
    os.mkfifo(folder / "pipe")
    with pytest.raises(InputError, match="pipe: is no file"):
        capture_files(folder)
    (folder / "pipe").unlink()
    (folder / "CAM00.MP4").touch()
    with pytest.raises(InputError, match="would be one file"):
        capture_files(folder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="is empty"):
        capture_files(tmp_path / "empty")


@pytest.mark.parametrize("inside", ["studio/", ""])
def test_an_archive_is_a_folder_for_as_long_as_it_is_needed(tmp_path: Path, inside: str) -> None:
    with zipfile.ZipFile(tmp_path / "Take 1.ZIP", "w") as archive:
        for name in ("cam00.mp4", "sparse/0/a.txt"):
            archive.writestr(inside + name, name)
        archive.writestr("__MACOSX/studio/._cam00.mp4", "junk")
    with opened_capture(tmp_path / "Take 1.ZIP", UploadLimits()) as (name, folder):
        assert name == "Take 1"
        assert [file.path for file in capture_files(folder)] == ["cam00.mp4", "sparse/0/a.txt"]
    assert not folder.exists()


def test_what_is_neither_folder_nor_archive_is_refused(folder: Path) -> None:
    with (
        pytest.raises(InputError, match=r"neither a folder nor an archive; archives are \.zip"),
        opened_capture(folder / "cam00.mp4", UploadLimits()),
    ):
        pass
