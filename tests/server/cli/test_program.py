"""The command line: bad input is one line on standard error, status 2, and nothing is written."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from hgs_core.runs.folder import RunFolder
from hgs_core.runs.stages import create_run
from hgs_core.train.config import TrainConfig
from server.cli import main
from server.cli.training_options import add_training_options, training_config

CAMERAS = 3
FRAMES = 4


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "home"
    monkeypatch.setenv("HGS_HOME", str(folder))
    for name in ("HGS_DATABASE_URL", "HGS_STORE_URL", "HGS_PIPELINE", "HGS_CAPTURES"):
        monkeypatch.delenv(name, raising=False)
    return folder


def write_video(path: Path, frames: int = FRAMES) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for k in range(frames):
            picture = np.full((48, 64, 3), 40 * k, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())


@pytest.fixture
def n3dv(tmp_path: Path) -> Path:
    """Three cameras side by side, 4 frames each, in the N3DV layout."""
    folder = tmp_path / "n3dv"
    folder.mkdir()
    pose = np.zeros((CAMERAS, 3, 5))
    pose[:, :, :3] = [[0, 1, 0], [1, 0, 0], [0, 0, -1]]  # columns down, right, backwards
    pose[:, 0, 3] = range(CAMERAS)
    pose[:, :, 4] = (48, 64, 60)
    np.save(folder / "poses_bounds.npy", np.concatenate([pose.reshape(CAMERAS, 15), np.ones((CAMERAS, 2))], axis=1))
    for camera in range(CAMERAS):
        write_video(folder / f"cam{camera:02}.mp4")
    return folder


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


@pytest.fixture
def refused(tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that runs a command, checks that it is refused in order, and returns the line it printed."""

    def run(*arguments: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        assert main([str(argument) for argument in arguments]) == 2
        output = capsys.readouterr()
        assert output.out == ""
        assert output.err.startswith("hgs: ")
        assert output.err.count("\n") == 1
        written = [path for path in sorted(tmp_path.rglob("*")) if path not in before and home not in path.parents]
        assert written in ([], [home])
        assert not list(home.glob("runs/*"))
        return output.err

    return run


def damage(capture: Path, how: str) -> str:
    """Damage a capture and return what the error must name."""
    if how == "corrupt mp4":
        video = capture / "cam01.mp4"
        video.write_bytes(video.read_bytes()[:300])
        return "cam01.mp4"
    if how == "one camera misses a frame":
        write_video(capture / "cam02.mp4", FRAMES - 1)
        return "cam02.mp4"
    (capture / "cam00.mp4").unlink()
    return "poses_bounds.npy"


@pytest.mark.parametrize("command", ["train", "submit"])
@pytest.mark.parametrize("how", ["corrupt mp4", "one camera misses a frame", "a video is missing"])
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
    create_run(tmp_path / "run", n3dv, TrainConfig.for_preset("preview"))
    assert "another capture or config" in refused("train", n3dv, "--out", tmp_path / "run", "--preset", "best")


@pytest.mark.parametrize(
    ("assignment", "word"),
    [
        ("iterations", "KEY=VALUE"),
        ("cycels=3", "cycels"),
        ("iterations=many", "iterations"),
        ("iterations=0", "iterations"),
        ("learning_rates.opacity=-1", "learning_rates.opacity"),
        ("seed.x=1", "seed"),
        ("iterations=Infinity", "config.iterations: inf is out of range"),
        ("dssim=NaN", "config.dssim: nan is out of range"),
        ("checkpoint_every=1000000000", "config.checkpoint_every: 1000000000 is out of range"),
        ("iterations=" + "9" * 5000, "config.iterations"),
        ("hold_out=" + "[" * 5000, "config.hold_out"),
        ("hold_out=3", "config.hold_out"),
    ],
    ids=lambda text: text[:24],
)
def test_bad_overrides_are_refused(
    refused: Callable[..., str], tmp_path: Path, n3dv: Path, assignment: str, word: str
) -> None:
    assert word in refused("train", n3dv, "--out", tmp_path / "run", "--set", assignment)


def test_overrides_are_read_as_json_and_nest() -> None:
    parser = argparse.ArgumentParser()
    add_training_options(parser)
    arguments = [
        "--preset",
        "preview",
        "--hold-out",
        "a, b",
        "--set",
        "iterations=9",
        "backend=cpu",
        "--set",
        "learning_rates.opacity=0.5",
    ]
    config = training_config(parser.parse_args(arguments))
    assert (config.preset, config.hold_out, config.iterations, config.backend) == ("preview", ("a", "b"), 9, "cpu")
    assert config.learning_rates.opacity == 0.5


@pytest.mark.parametrize("command", ["eval", "publish", "serve"])
def test_folder_that_is_no_run_is_refused(refused: Callable[..., str], tmp_path: Path, command: str) -> None:
    port = ["--port", "0"] if command == "serve" else []
    assert str(tmp_path) in refused(command, tmp_path, *port)


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


def test_submit_queues_a_job(n3dv: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["submit", str(n3dv), "--preset", "preview", "--title", "Three"]) == 0
    job_id = capsys.readouterr().out.strip()
    assert (home / "runs" / job_id / "run.json").is_file()


def test_a_submitted_run_keeps_its_masks(
    n3dv: Path, home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "given" / "cam00"
    folder.mkdir(parents=True)
    for frame in range(FRAMES):
        Image.fromarray(np.full((48, 64), 255, np.uint8)).save(folder / f"{frame:04d}.png")
    assert main(["submit", str(n3dv), "--masks", str(folder.parent)]) == 0
    job_id = capsys.readouterr().out.strip()
    assert RunFolder(home / "runs" / job_id).read_spec().masks == folder.parent.resolve()


def test_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out.startswith("hgs ")
