from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.capture.capture import Capture
from server.cli import main
from tests.synthetic import write_capture


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    write_capture(tmp_path, cameras=3, frames=2)
    return tmp_path


def found(monkeypatch: pytest.MonkeyPatch, offsets: list[float | None]) -> None:
    monkeypatch.setattr("hgs_core.check.synchronise.find_offsets", lambda capture, progress: offsets)


def test_offsets_are_written_in_frames(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found(monkeypatch, [0.0, 2.512, -1.0])
    assert main(["sync", str(capture)]) == 0
    assert json.loads((capture / "sync.json").read_text()) == {"frames": {"0": 0.0, "1": 2.51, "2": -1.0}}


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
    assert "too little that moves is seen by 1;" in capsys.readouterr().err
    assert not (capture / "sync.json").exists()


def test_footage_that_time_stamps_put_in_step_is_refused(
    capture: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Offsets of what is left would take the place of those that the stamps gave."""
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
