from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.calibrate.board import Board
from hgs_core.calibrate.structure import Solution, SolvedCamera
from hgs_core.calibrate.upright import Distance
from server.cli import main

SOLUTION = Solution(
    (SolvedCamera("cam00", 64, 48, "PINHOLE", (70.0, 70, 32, 24), np.eye(4), 1234),), np.zeros((0, 3)), 0.41
)


def test_options_reach_the_solver_and_the_cameras_are_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: dict[str, object] = {}

    def find(folder: Path, **options: object) -> Solution:
        asked.update(options, folder=folder)
        return SOLUTION

    monkeypatch.setattr("hgs_core.calibrate.find_cameras.find_cameras", find)
    line = ["cameras", str(tmp_path), "--focal", "500", "--up", "cam00", "--distance", "cam00, cam01=3.2"]
    assert main(line) == 0
    assert (asked["folder"], asked["focal"], asked["up"]) == (tmp_path, 500.0, "cam00")
    assert asked["distance"] == Distance("cam00", "cam01", 3.2)
    output = capsys.readouterr()
    assert output.out == f"{tmp_path / 'sparse' / '0'}\n"
    assert "cam00       70.0   1,234" in output.err


@pytest.mark.parametrize(
    ("option", "value"),
    [("--distance", "cam00=3"), ("--distance", "a,b=far"), ("--distance", "a,b=-1"), ("--focal", "0")],
)
def test_bad_options_are_refused(option: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cameras", str(tmp_path), option, value]) == 2
    assert option in capsys.readouterr().err


def test_a_board_is_described_by_options(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cv2")
    asked: dict[str, object] = {}
    monkeypatch.setattr(
        "hgs_core.calibrate.find_cameras.find_cameras", lambda folder, **options: asked.update(options) or SOLUTION
    )
    line = ["cameras", str(tmp_path), "--board", "8x5", "--square", "0.04", "--dictionary", "DICT_5X5_100", "--floor"]
    assert main(line) == 0
    assert asked["board"] == Board(8, 5, 0.04, 0.03, "5X5_100")
    assert asked["floor"] is True
    assert "arbitrary" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--board", "8", "--square", "0.04"], "'8' is no number of squares"),
        (["--board", "8x5"], "the side of its squares is not given"),
        (["--square", "0.04"], "there is no --board"),
        (["--board", "8x5", "--square", "0.04", "--distance", "a,b=2"], "says how large the rig is"),
        (["--board", "8x5", "--square", "0.04", "--floor", "--up", "a"], "says what is level"),
    ],
)
def test_a_board_that_is_half_described_is_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cameras", str(tmp_path), *options]) == 2
    assert said in capsys.readouterr().err


def test_videos_of_a_folder_inside_are_called_so(
    n3dv: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("hgs_core.calibrate.find_cameras.find_cameras", lambda folder, **options: SOLUTION)
    (n3dv / "poses_bounds.npy").unlink()
    outer = n3dv.parent / "outer"
    outer.mkdir()
    n3dv.rename(outer / "inside")
    assert main(["cameras", str(outer)]) == 0
    assert f"{outer}: has no videos of its own; those of {outer / 'inside'} are taken" in capsys.readouterr().err
    assert main(["cameras", str(outer / "inside")]) == 0
    assert "of its own" not in capsys.readouterr().err
