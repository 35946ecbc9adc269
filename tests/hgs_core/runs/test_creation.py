"""A run is created of a trainable capture, and nothing is written for any other."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.creation import create_run
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from tests.synthetic import write_capture

CONFIG = RunConfig.from_json({"capture": {"hold_out": ["2"]}})


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


def test_an_equal_run_is_kept_and_a_different_one_refused(capture: Path, tmp_path: Path) -> None:
    create_run(tmp_path / "run", capture, CONFIG)
    before = (tmp_path / "run" / "run.json").read_bytes()
    create_run(tmp_path / "run", capture, CONFIG)
    with pytest.raises(InputError, match="another capture or config"):
        create_run(tmp_path / "run", capture, CONFIG.changed({"seed": 5}))
    assert (tmp_path / "run" / "run.json").read_bytes() == before


def test_a_folder_with_other_files_is_not_touched(capture: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(InputError, match="is not a run"):
        create_run(tmp_path, capture, CONFIG)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    ("hold_out", "problem"), [(["7"], "7"), (["0", "1", "2", "3"], "leaves 1 of 5 cameras to train on")]
)
def test_bad_hold_outs_are_refused_before_anything_is_written(
    capture: Path, tmp_path: Path, hold_out: list[str], problem: str
) -> None:
    config = CONFIG.changed({"capture.hold_out": hold_out})
    with pytest.raises(InputError, match=problem):
        create_run(tmp_path / "run", capture, config)
    assert not (tmp_path / "run").exists()


def test_of_six_cameras_one_is_held_out_where_the_choice_is_left(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_capture(tmp_path / "capture", cameras=6, frames=1)
    config = CONFIG.changed({"capture.hold_out": AUTO})
    made = create_run(tmp_path / "run", tmp_path / "capture", config)
    assert made.capture.hold_out == RunFolder(tmp_path / "run").read_spec().config.capture.hold_out == ("2",)
    assert "camera 2 is held out" in caplog.text
    assert create_run(tmp_path / "run", tmp_path / "capture", config) == made
    # A run that was made with another choice is resumed as it was made.
    create_run(tmp_path / "mine", tmp_path / "capture", CONFIG.changed({"capture.hold_out": ["0"]}))
    assert create_run(tmp_path / "mine", tmp_path / "capture", config).capture.hold_out == ("0",)


def test_the_sound_of_a_camera_that_has_none_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    write_capture(tmp_path / "capture", frames=2)
    for audio, words in (("camera:9", "no such camera"), ("camera:0", "has no video with sound")):
        with pytest.raises(InputError, match=words):
            create_run(tmp_path / "run", tmp_path / "capture", CONFIG, GivenFiles(audio=audio))
    assert not (tmp_path / "run").exists()


def test_a_run_keeps_its_masks_and_its_resolution(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_capture(tmp_path / "capture", frames=2)
    for frame in range(2):
        file = tmp_path / "masks" / "0" / f"{frame:04d}.png"
        file.parent.mkdir(parents=True, exist_ok=True)
        Image.new("L", (64, 48), 255 * frame).save(file)
    monkeypatch.chdir(tmp_path)
    config = CONFIG.changed({"capture.downscale": 2})
    for _ in range(2):  # the second time the run is resumed
        create_run(Path("run"), Path("capture"), config, GivenFiles(Path("masks")))
    assert "the masks of 0 are given" in caplog.text
    monkeypatch.chdir("/")
    capture = RunFolder(tmp_path / "run").read_spec().open_capture()
    assert capture.frame(0, 0).shape == (24, 32, 3)
    assert [capture.mask(0, frame).mean() for frame in range(2)] == [0, 1]  # type: ignore[union-attr]
    with pytest.raises(InputError, match="another capture or config"):
        create_run(tmp_path / "run", tmp_path / "capture", config)
    (tmp_path / "masks" / "0" / "0001.png").write_bytes(b"edited")
    with pytest.raises(InputError):
        RunFolder(tmp_path / "run").read_spec().open_capture()


def test_videos_without_poses_are_read_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "capture").mkdir()
    for number in range(3):
        (tmp_path / "capture" / f"cam{number}.mp4").write_bytes(b"no video")
    with pytest.raises(InputError, match=r"cam0.mp4: the video is unreadable"):
        create_run(tmp_path / "run", tmp_path / "capture", CONFIG)
    assert not (tmp_path / "run").exists()
