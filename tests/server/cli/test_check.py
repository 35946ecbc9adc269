from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.base.progress import ProgressCallback
from hgs_core.capture.cameras.corrected_poses import CorrectedCamera, corrections_of
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.check.findings import CameraResult, CaptureCheck, Finding
from server.cli import main
from tests.hgs_core.check.conftest import write_studio
from tests.synthetic import write_capture

RESULT = CameraResult("0", 4, 100, 0.2, None)
FAULT = Finding(True, ("0",), "it is upside down", "turn it")


def checked(monkeypatch: pytest.MonkeyPatch, folder: Path, *findings: Finding) -> str:
    write_capture(folder, frames=1)
    result = CaptureCheck((RESULT,), findings, (), (0,), 64)
    monkeypatch.setattr("hgs_core.check.capture_check.check_capture", lambda capture, progress: result)
    return str(folder)


def test_a_sound_capture_prints_its_table_and_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", checked(monkeypatch, tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "nothing stands out"


def test_a_fault_is_bad_input_told_in_one_line_below_the_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", checked(monkeypatch, tmp_path, FAULT)]) == 2
    output = capsys.readouterr()
    assert "stop: 0: it is upside down; turn it" in output.out
    assert output.err.splitlines()[-1].startswith(f"hgs: {tmp_path}, camera 0: it is upside down")


def test_the_result_is_there_as_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", checked(monkeypatch, tmp_path, FAULT), "--json", "-"]) == 2
    value = json.loads(capsys.readouterr().out)
    assert value["stops"] is True
    assert value["findings"][0]["cameras"] == ["0"]


def test_a_real_capture_of_tiny_pictures_is_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_capture(tmp_path)
    assert main(["check", str(tmp_path)]) == 0
    assert len([line for line in capsys.readouterr().out.splitlines() if line[0] in "01234"]) == 5


def inverted(poses: npt.NDArray[np.float64]) -> None:
    """Rows of poses_bounds.npy with the inverse matrices of a left-handed world."""
    for row in poses:
        matrix = row[:15].reshape(3, 5)
        matrix[0, :4] *= -1
        turn, place = matrix[:, :3].copy(), matrix[:, 3].copy()
        matrix[:, :3], matrix[:, 3] = turn.T, -turn.T @ place


def test_wrong_poses_are_corrected_beside_the_capture_and_checked_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capture = write_studio(tmp_path / "studio", inverted)
    before = (capture / "poses_bounds.npy").read_bytes()
    assert main(["check", str(capture), "--fix-poses"]) == 0
    output = capsys.readouterr()
    assert "stop: the poses of all cameras are reflections: the poses are inverted" in output.err
    assert output.out.splitlines()[-1] == "nothing stands out"
    assert (capture / "poses_bounds.npy").read_bytes() == before
    assert main(["check", str(capture), "--fix-poses"]) == 2
    assert "poses.json: is there already; move it away" in capsys.readouterr().err


def test_mistakes_upon_mistakes_are_corrected_in_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_capture(tmp_path)
    cameras = open_capture(tmp_path).cameras
    first = CorrectedCamera("0", cameras[1].world_to_camera, "1"), CorrectedCamera("1", cameras[0].world_to_camera, "0")
    rounds = [(first,), ((CorrectedCamera("0", cameras[2].world_to_camera, "1", 2.0),),), ()]

    def found(capture: Capture, progress: ProgressCallback) -> CaptureCheck:
        findings = tuple(Finding(True, (), "they are swapped", "swap them", corrected=one) for one in rounds.pop(0))
        return CaptureCheck((RESULT,), findings, (), (0,), 64)

    monkeypatch.setattr("hgs_core.check.capture_check.check_capture", found)
    assert main(["check", str(tmp_path), "--fix-poses"]) == 0
    names = [camera.name for camera in cameras]
    written = corrections_of(tmp_path, names)
    assert {name: (one.calibration, one.focal) for name, one in written.items()} == {"0": ("0", 2.0), "1": ("0", 1.0)}
    assert "they are swapped; they are swapped" in (tmp_path / "poses.json").read_text()


def test_what_has_no_cure_is_said_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", checked(monkeypatch, tmp_path, FAULT), "--fix-poses"]) == 2
    assert "nothing is written" in capsys.readouterr().err
    assert not (tmp_path / "poses.json").exists()
