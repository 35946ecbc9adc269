from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.runs.given_files import GivenFiles

ALL = GivenFiles(Path("masks"), Path("depth"), Path("mesh.ply"), "recorder.wav")


@pytest.mark.parametrize("given", [GivenFiles(), ALL, GivenFiles(audio="none")])
def test_files_come_back_as_they_were_written(given: GivenFiles) -> None:
    assert GivenFiles.from_json({"capture": "studio", **given.to_json()}) == given


def test_what_is_the_capture_s_own_is_not_written() -> None:
    assert GivenFiles(mesh=Path("a.obj")).to_json() == {"mesh": "a.obj"}


def test_paths_become_absolute_and_the_sound_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert ALL.resolved() == GivenFiles(tmp_path / "masks", tmp_path / "depth", tmp_path / "mesh.ply", "recorder.wav")
