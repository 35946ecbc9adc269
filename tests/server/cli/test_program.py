"""The command line: bad input is one line on standard error, status 2, and nothing is written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from server.cli import main
from tests.server.cli.conftest import FRAMES


@pytest.fixture
def panoptic(tmp_path: Path) -> Path:
    """Two cameras, 4 pictures each, in the PanopticSports layout."""
    folder = tmp_path / "panoptic"
    names = [[f"{camera}/{frame:06}.jpg" for camera in range(2)] for frame in range(FRAMES)]
    for row in names:
        for name in row:
            (folder / "ims" / name).parent.mkdir(parents=True, exist_ok=True)
            Image.new("RGB", (64, 48)).save(folder / "ims" / name)
    meta = {
        "w": 64,
        "h": 48,
        "k": [[[[60, 0, 32], [0, 60, 24], [0, 0, 1]]] * 2] * FRAMES,
        "w2c": [[np.eye(4).tolist()] * 2] * FRAMES,
        "fn": names,
        "cam_id": [[0, 1]] * FRAMES,
    }
    (folder / "train_meta.json").write_text(json.dumps(meta))
    return folder


def damage(capture: Path, how: str) -> str:
    """Damage a capture and return the words that the error must contain."""
    if how == "corrupt mp4":
        video = capture / "cam01.mp4"
        video.write_bytes(video.read_bytes()[:300])
        return "cam01.mp4"
    if how == "a camera began an hour later":
        (capture / "sync.json").write_text('{"seconds": {"cam02": 3600}}')
        return "no moment in common"
    (capture / "cam00.mp4").unlink()
    return "poses_bounds.npy"


@pytest.mark.parametrize("command", ["train", "submit"])
@pytest.mark.parametrize("how", ["corrupt mp4", "a camera began an hour later", "a video is missing"])
def test_damaged_capture_is_refused(
    refused: Callable[..., str], tmp_path: Path, n3dv: Path, command: str, how: str
) -> None:
    name = damage(n3dv, how)
    out = ["--out", tmp_path / "run"] if command == "train" else []
    assert name in refused(command, n3dv, *out)


@pytest.mark.parametrize("command", ["train", "submit"])
def test_missing_picture_is_refused(refused: Callable[..., str], tmp_path: Path, panoptic: Path, command: str) -> None:
    (panoptic / "ims" / "1" / "000002.jpg").unlink()
    out = ["--out", tmp_path / "run"] if command == "train" else []
    line = refused(command, panoptic, *out)
    assert "camera 1" in line
    assert "000002.jpg" in line


def test_empty_folder_is_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert "empty" in refused("train", tmp_path / "empty", "--out", tmp_path / "run")


def test_path_that_does_not_exist_is_refused(refused: Callable[..., str], tmp_path: Path) -> None:
    assert "does not exist" in refused("train", tmp_path / "nothing", "--out", tmp_path / "run")


def test_unknown_hold_out_camera_is_refused(refused: Callable[..., str], tmp_path: Path, n3dv: Path) -> None:
    assert "cam09" in refused("train", n3dv, "--out", tmp_path / "run", "--hold-out", "cam00,cam09")


def test_folder_that_is_no_run_is_not_overwritten(refused: Callable[..., str], tmp_path: Path, n3dv: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "dear.jpg").write_bytes(b"")
    assert "is not a run" in refused("train", n3dv, "--out", tmp_path / "photos")


def test_run_of_another_config_is_not_resumed(refused: Callable[..., str], tmp_path: Path, n3dv: Path) -> None:
    create_run(tmp_path / "run", n3dv, RunConfig.for_preset("preview"))
    assert "another capture or config" in refused("train", n3dv, "--out", tmp_path / "run", "--preset", "best")


@pytest.mark.parametrize("command", ["eval", "publish", "serve"])
def test_folder_that_is_no_run_is_refused(refused: Callable[..., str], tmp_path: Path, command: str) -> None:
    port = ["--port", "0"] if command == "serve" else []
    assert str(tmp_path) in refused(command, tmp_path, *port)


def test_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out.startswith("hgs ")
