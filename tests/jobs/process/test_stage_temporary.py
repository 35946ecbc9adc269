from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from jobs.process import stage_temporary
from jobs.process.stage_temporary import temporary_folder


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of this test's temporary folders."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(stage_temporary, "_YOUNGEST", -1.0)
    return tmp_path


def test_the_folder_and_its_files_are_gone_afterwards(place: Path) -> None:
    with temporary_folder() as folder:
        assert folder.parent == place
        (folder / "file").touch()
    assert list(place.iterdir()) == []


def test_folders_in_use_stay(place: Path) -> None:
    with temporary_folder() as first:
        with temporary_folder() as second:
            assert {first, second} == set(place.iterdir())
        assert first.is_dir()


def test_the_folder_of_a_killed_process_is_removed(place: Path) -> None:
    program = (
        "import os, tempfile; from jobs.process.stage_temporary import temporary_folder\n"
        f"tempfile.tempdir = {str(place)!r}\n"
        "with temporary_folder() as folder: (folder / 'file').touch(); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", program]).returncode == 9
    (left,) = place.iterdir()
    with temporary_folder():
        assert not left.exists()


def test_what_is_young_or_another_s_stays(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage_temporary, "_YOUNGEST", 1e6)
    (place / "hgs-stage-young").mkdir()
    (place / "other").mkdir()
    elsewhere = place / "elsewhere"
    elsewhere.mkdir()
    link = place / "hgs-stage-link"
    link.symlink_to(elsewhere)
    os.utime(link, (0, 0), follow_symlinks=False)
    with temporary_folder():
        assert {"hgs-stage-young", "other", "elsewhere", "hgs-stage-link"} < {path.name for path in place.iterdir()}
