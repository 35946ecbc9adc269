"""`hgs publish`; what it does is tested in tests/server/test_publishing.py and test_web_folder.py."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hgs_core.runs.config import RunConfig
from hgs_core.runs.folder import RunFolder, RunSpec
from server.cli import main


def test_publish_prints_the_id(scene_folder: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["publish", str(scene_folder), "--id", "studio"]) == 0
    assert capsys.readouterr().out == "studio\n"
    assert (home / "store" / "scenes" / "studio" / "manifest.json").is_file()


def test_publish_to_a_folder_prints_it(
    scene_folder: Path, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["publish", str(scene_folder), "--to", str(tmp_path / "web"), "--data-only"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'web'}\n"
    assert (tmp_path / "web" / "manifest.json").is_file()
    assert not (tmp_path / "web" / "index.html").exists()
    assert not home.exists()


def test_publish_gives_the_scene_sound_or_takes_it(
    scene_folder: Path, home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted: list[tuple[Path, str]] = []
    monkeypatch.setattr("hgs_core.runs.sound.replace_sound", lambda run, audio: wanted.append((run, audio)))
    RunFolder(scene_folder).replace_spec(RunSpec(tmp_path, "", RunConfig(), without_capture=True))
    assert main(["publish", str(scene_folder), "--to", str(tmp_path / "web"), "--data-only", "--audio", "a.wav"]) == 0
    assert main(["publish", str(scene_folder), "--to", str(tmp_path / "web"), "--data-only"]) == 0
    assert wanted == [(scene_folder, "a.wav")]


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--replace"], "--replace: needs --to"),
        (["--data-only"], "--data-only: needs --to"),
        (["--to", "web", "--id", "studio"], "--id: 'studio' names a scene in the store"),
    ],
)
def test_publish_options_that_do_not_go_together_are_refused(
    refused: Callable[..., str], scene_folder: Path, arguments: list[str], problem: str
) -> None:
    assert problem in refused("publish", scene_folder, *arguments)
