"""`hgs render`, of a run that was imported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import av
import pytest

from server.cli import main


@pytest.mark.parametrize("path", ["orbit", "cameras"])
def test_a_run_becomes_a_film(path: str, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = tmp_path / "film.mp4"
    assert main(["render", str(run), "--out", str(film), "--path", path, "--size", "64x48", "--fps", "60"]) == 0
    assert capsys.readouterr().out == f"{film}\n"
    with av.open(str(film)) as file:
        assert file.streams.video[0].average_rate == 60
        assert (file.streams.video[0].width, file.streams.video[0].height) == (64, 48)


def test_a_scene_folder_becomes_pictures(run: Path, tmp_path: Path) -> None:
    frames = tmp_path / "frames"
    assert main(["render", str(run / "scene"), "--out", str(frames), "--size", "33x21", "--alpha"]) == 0
    assert len(list(frames.glob("*.png"))) >= 5


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--size", "64"], "--size: '64' is no size"),
        (["--fps", "0"], "--fps: '0' is no rate"),
        (["--path", "nowhere.json"], "nowhere.json: cannot be read"),
    ],
)
def test_wrong_options_are_refused(
    arguments: list[str], told: str, run: Path, tmp_path: Path, refused: Callable[..., str]
) -> None:
    assert told in refused("render", run, "--out", tmp_path / "x.mp4", *arguments)


def test_a_folder_that_is_neither_run_nor_scene_is_refused(tmp_path: Path, refused: Callable[..., str]) -> None:
    assert "is neither a finished run nor a scene folder" in refused("render", tmp_path, "--out", tmp_path / "x.mp4")
