"""`hgs publish`; tests/server/publishing tests its results."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec
from server.cli import main
from server.publishing.static_folder import Transfer


def test_publish_prints_the_id(scene_folder: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["publish", str(scene_folder), "--id", "studio"]) == 0
    assert capsys.readouterr().out == "studio\n"
    assert (home / "store" / "scenes" / "studio" / "manifest.json").is_file()


def test_publish_to_a_folder_prints_it(
    scene_folder: Path, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["publish", str(scene_folder), "--to", str(tmp_path / "web"), "--data-only"]) == 0
    output = capsys.readouterr()
    assert output.out == f"{tmp_path / 'web'}\n"
    assert re.search(r"^8 files written, \d+\.\d kB$", output.err, re.M)
    assert main(["publish", str(scene_folder), "--to", str(tmp_path / "web"), "--data-only"]) == 0
    assert re.search(r"^0 files written, 0 bytes; 8 already there$", capsys.readouterr().err, re.M)
    assert (tmp_path / "web" / "manifest.json").is_file()
    assert not (tmp_path / "web" / "index.html").exists()
    assert not home.exists()


def test_publish_to_a_bucket_prints_its_address(
    scene_folder: Path, home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wanted: list[tuple[Any, ...]] = []

    def publish(run: Path, url: str, *, player: Path | None, replace: bool, progress: object) -> Transfer:
        wanted.append((run, url, player, replace))
        return Transfer(2, 1_500_000, 1)

    monkeypatch.setattr("server.publishing.web_bucket.publish_to_bucket", publish)
    assert main(["publish", str(scene_folder), "--to", "s3://bucket/scene", "--data-only", "--replace"]) == 0
    assert wanted == [(scene_folder, "s3://bucket/scene", None, True)]
    output = capsys.readouterr()
    assert output.out == "s3://bucket/scene\n"
    assert output.err == "2 files written, 1.5 MB; 1 already there\n"
    assert not home.exists()


@pytest.mark.parametrize("address", ["s3:/bucket/scene", "gs://bucket/scene"])
def test_an_address_that_is_no_buckets_is_refused_and_not_taken_for_a_folder(
    refused: Callable[..., str], scene_folder: Path, address: str
) -> None:
    assert f"{address}: is not the URL of a bucket" in refused("publish", scene_folder, "--to", address)


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
