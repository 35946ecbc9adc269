"""`hgs ablate`, on a capture so small that it says nothing."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import pytest

import hgs_core.ablate.ablation
from hgs_core.base.progress import Progress, ProgressCallback
from server.cli import main
from tests.synthetic import write_capture

TINY = [
    "--hold-out",
    "1",
    "--set",
    "train.iterations=2",
    "points.static=60",
    "points.dynamic=20",
    "points.interval=0.05",
    "train.density.max_static=80",
    "train.density.max_dynamic=40",
]


@pytest.fixture(scope="module")
def arguments(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The command without its choice of rows."""
    folder = tmp_path_factory.mktemp("ablate")
    write_capture(folder / "capture", cameras=4, frames=3, width=48, height=36)
    return ["ablate", str(folder / "capture"), "--out", str(folder / "out"), *TINY]


def test_the_table_and_the_json_say_the_same(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "result.json"
    assert main([*arguments, "--rows", "no-births", "--seeds", "0,1", "--json", str(file)]) == 0
    output = capsys.readouterr()
    result = json.loads(file.read_text())
    for row in result["rows"]:
        (line,) = (line for line in output.out.splitlines() if line.startswith(f"| {row['name']} "))
        assert f"{row['mean']['psnr']:.2f} ±{row['deviation']['psnr']:.2f}" in line
    assert "no-births 1 train" in output.err
    assert main([*arguments, "--rows", "no-births", "--seeds", "0,1", "--json"]) == 0
    output = capsys.readouterr()
    assert json.loads(output.out) == result
    assert output.err == ""


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        (["--rows", "order-4"], "order-4"),
        (["--rows", ","], "--rows"),
        (["--seeds", "one"], "--seeds"),
        (["--seeds", "-1"], "--seeds"),
        (["--hold-out", ""], "--hold-out"),
        (["--set", "cycels=3"], "cycels"),
        (["--json", "/nowhere/ablation.json"], "/nowhere/ablation.json"),
    ],
)
def test_bad_options_are_one_line(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], word: str
) -> None:
    assert main([*arguments, "--out", str(tmp_path / "out"), *wrong]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert word in output.err
    assert output.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_interrupt_stops_in_order_and_is_130(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(ablation: object, progress: ProgressCallback) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        progress(Progress("full 0 train", 1, 2))

    monkeypatch.setattr(hgs_core.ablate.ablation, "ablate", interrupted)
    assert main(arguments) == 130
    assert "run the same command again to resume" in capsys.readouterr().err
