"""Backups of homes while they are used."""

from __future__ import annotations

import hashlib
import shutil
import sqlite3
import subprocess
from contextlib import closing
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.backup.home_backup import back_up
from jobs.home.home import Home
from tests.chunks import static_chunk


def test_its_files_can_be_compared_by_others(used: Home, tmp_path: Path) -> None:
    back_up(used, tmp_path / "backup")
    if shutil.which("sha256sum") is None:
        pytest.skip("sha256sum is not installed")
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=tmp_path / "backup", check=True)


def test_a_writer_is_not_waited_for(used: Home, tmp_path: Path) -> None:
    """A transaction that is open has not happened yet."""
    with closing(sqlite3.connect(used.folder / "jobs.sqlite")) as writer:
        writer.execute("BEGIN IMMEDIATE")
        writer.execute("DELETE FROM hgs_key")
        back_up(used, tmp_path / "backup")
    with closing(sqlite3.connect(tmp_path / "backup" / "jobs.sqlite")) as copy:
        assert copy.execute("SELECT name FROM hgs_key").fetchall() == [("anna",)]
        assert copy.execute("PRAGMA integrity_check").fetchall() == [("ok",)]


def test_where_there_is_no_home_there_is_no_backup(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no home"):
        back_up(Home.at(tmp_path / "nothing"), tmp_path / "backup")
    assert list(tmp_path.iterdir()) == []


def test_holes_of_the_home_are_told(used: Home, tmp_path: Path) -> None:
    chunk = hashlib.sha256(static_chunk(b"1")).hexdigest()
    (used.folder / "store" / "chunks" / chunk).unlink()
    assert back_up(used, tmp_path / "backup").holes == (chunk,)
