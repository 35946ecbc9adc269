from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.capture.capture import Capture
from server.cli import main
from tests.hgs_core.capture.sounding import write_sounding_video
from tests.hgs_core.check.test_starts_by_sound import heard, scene
from tests.synthetic import write_capture


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    write_capture(tmp_path, cameras=3, frames=2)
    return tmp_path


def found(monkeypatch: pytest.MonkeyPatch, offsets: list[float | None]) -> None:
    monkeypatch.setattr("hgs_core.check.starts.find_offsets", lambda capture, progress: offsets)


def test_offsets_are_written_in_frames(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found(monkeypatch, [0.0, 2.512, -1.0])
    assert main(["sync", str(capture)]) == 0
    assert json.loads((capture / "sync.json").read_text()) == {
        "frames": {"0": 0.0, "1": 2.51, "2": -1.0},
        "by": "motion",
    }


def test_what_is_there_is_kept(
    capture: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch, [0.0, 0.0, 0.0])
    (capture / "sync.json").write_text("{}")
    assert main(["sync", str(capture)]) == 2
    assert "is there already" in capsys.readouterr().err


def test_a_camera_that_nothing_tells_of_is_named_and_nothing_is_written(
    capture: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found(monkeypatch, [0.0, None, 1.0])
    assert main(["sync", str(capture)]) == 2
    assert "2 frames are too few" in capsys.readouterr().err
    monkeypatch.setattr("hgs_core.check.starts.FEWEST_FRAMES", 2)
    assert main(["sync", str(capture)]) == 2
    assert "too little that moves is seen by 1;" in capsys.readouterr().err
    assert not (capture / "sync.json").exists()


def test_footage_that_time_stamps_put_in_step_is_refused(
    capture: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Offsets of the rest would replace those of the stamps."""
    found(monkeypatch, [0.0, 0.0, 0.0])
    monkeypatch.setattr(Capture, "number", lambda self, camera, frame: frame + (camera == 1))
    assert main(["sync", str(capture)]) == 2
    assert "time stamps of camera 1 already say when it began; remove them" in capsys.readouterr().err
    assert not (capture / "sync.json").exists()
    monkeypatch.undo()
    found(monkeypatch, [0.0, 0.0, 0.0])
    later = Capture.moment
    monkeypatch.setattr(
        Capture, "moment", lambda self, camera, frame: later(self, camera, frame) + 0.01 * (camera == 2)
    )
    assert main(["sync", str(capture)]) == 2
    assert "time stamps of camera 2" in capsys.readouterr().err


def test_videos_without_poses_are_told_by_their_sound(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound = 0.2 * scene(5)
    for name, start in (("a", 0.25), ("b", 0.0)):
        write_sounding_video(tmp_path / f"{name}.mkv", 3, heard(sound, start))
    assert main(["sync", str(tmp_path), "--by", "audio"]) == 0
    written = json.loads((tmp_path / "sync.json").read_text())
    assert written["seconds"] == pytest.approx({"a": 0.25, "b": 0.0}, abs=2e-4)
    assert "confidence" in capsys.readouterr().out


def test_pictures_have_no_sound(capture: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sync", str(capture), "--by", "audio"]) == 2
    assert "have no sound; go by what moves" in capsys.readouterr().err
