from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.check.findings import CameraResult, CaptureCheck, Finding
from server.cli import main
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
