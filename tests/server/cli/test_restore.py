"""`hgs restore`; a server on a restored home is in test_backup.py."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from jobs.home.home import Home
from jobs.records.keys import KeyTable
from server.cli import main


def test_a_home_is_made_once(home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with closing(KeyTable(Home.at(home))) as table:
        table.secret()
    assert main(["backup", str(tmp_path / "copy")]) == 0
    assert main(["restore", str(tmp_path / "copy")]) == 2
    assert "is not empty" in capsys.readouterr().err
    home.rename(tmp_path / "away")
    assert main(["restore", str(tmp_path / "copy")]) == 0
    assert capsys.readouterr().out.startswith(f"{home} is the home of ")


def test_bad_input_is_one_line(home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["restore", str(tmp_path / "copy")]) == 2
    assert "is no backup: it has no backup.json; give a folder of hgs backup" in capsys.readouterr().err
