from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput

RESULT = {"psnr": 27.5, "cameras": ["a"]}


def test_without_the_option_there_is_text_alone(capsys: pytest.CaptureFixture[str]) -> None:
    JsonOutput(None).show(RESULT, "27.5 dB")
    assert capsys.readouterr().out == "27.5 dB\n"


def test_a_dash_puts_json_in_place_of_the_text(capsys: pytest.CaptureFixture[str]) -> None:
    JsonOutput("-").show(RESULT, "27.5 dB")
    assert json.loads(capsys.readouterr().out) == RESULT


def test_a_file_gets_the_json_beside_the_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    JsonOutput(str(tmp_path / "scores.json")).show(RESULT, "27.5 dB")
    assert capsys.readouterr().out == "27.5 dB\n"
    assert json.loads((tmp_path / "scores.json").read_text()) == RESULT


@pytest.mark.parametrize("file", [".", "missing/scores.json"])
def test_what_can_be_no_file_is_refused_before_anything_is_measured(tmp_path: Path, file: str) -> None:
    with pytest.raises(InputError, match=r"--json: .* is not a file in a folder that exists"):
        JsonOutput(str(tmp_path / file))


def test_what_json_does_not_know_is_never_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        JsonOutput(str(tmp_path / "scores.json")).show({"psnr": float("inf")}, "")
    assert not any(tmp_path.iterdir())
