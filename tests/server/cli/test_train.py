from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

import hgs_core.runs.stages
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped
from server.cli import main

Stage = Callable[[Path, ProgressCallback], None]


@pytest.fixture
def run_stages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Return a function that runs `hgs train` with the given stages in the place of the real ones."""

    def run(**stages: Stage) -> int:
        monkeypatch.setattr(hgs_core.runs.stages, "create_run", lambda run, *_, **__: run.mkdir())
        monkeypatch.setattr(hgs_core.runs.stages, "STAGES", stages)
        return main(["train", str(tmp_path), "--out", str(tmp_path / "run")])

    return run


def test_stages_run_in_order_with_a_bar_each(
    run_stages: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[tuple[str, Path]] = []

    def stage(name: str) -> Stage:
        def run(folder: Path, progress: ProgressCallback) -> None:
            seen.append((name, folder))
            progress(Progress(name, 1, 2, {"psnr": 27.125}))
            progress(Progress(name, 2, 2, {"psnr": 28.5, "splats": 1000.0}))

        return run

    assert run_stages(initialise=stage("initialise"), train=stage("train")) == 0
    assert seen == [("initialise", tmp_path / "run"), ("train", tmp_path / "run")]
    output = capsys.readouterr()
    assert output.out == f"{tmp_path / 'run'}\n"
    for words in ("initialise", "train", "2/2", "psnr=28.5", "splats=1000"):
        assert words in output.err


def test_interrupt_stops_the_stage_in_order_and_is_130(
    run_stages: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    saved = []

    def stage(folder: Path, progress: ProgressCallback) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        try:
            progress(Progress("train", 1, 2))
        except StageStopped:
            saved.append(True)
            raise

    before = signal.getsignal(signal.SIGINT)
    assert run_stages(train=stage) == 130
    assert saved == [True]
    assert signal.getsignal(signal.SIGINT) is before
    assert "run the same command again to resume" in capsys.readouterr().err


def test_faults_are_not_hidden(run_stages: Callable[..., int]) -> None:
    def stage(folder: Path, progress: ProgressCallback) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_stages(train=stage)
