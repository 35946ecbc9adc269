from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

import hgs_core.runs.stages
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped
from hgs_core.runs.training_need import TrainingNeed
from server.cli import main
from tests.synthetic import write_capture

Stage = Callable[[Path, ProgressCallback], None]


@pytest.fixture
def run_stages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Return a function that runs `hgs train` with the given stages in the place of the real ones."""

    def run(need: TrainingNeed | None = None, **stages: Stage) -> int:
        monkeypatch.setattr(hgs_core.runs.stages, "create_run", lambda run, *_, **__: run.mkdir())
        monkeypatch.setattr(hgs_core.runs.stages, "require_room", lambda run: need)
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


def test_the_need_is_stated_first_and_the_rest_of_the_whole_training_is_shown(
    run_stages: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    need = TrainingNeed({"train": 3 << 30}, 0, 2_000_000_000, {"check": 0.01, "train": 7200.0}, (1.0,))
    minutes = need.seconds()["train"] / 60

    def check(folder: Path, progress: ProgressCallback) -> None:
        progress(Progress("check", 0, 1))

    assert run_stages(need, check=check) == 0
    first, rest = capsys.readouterr().err.split("\n", 1)
    assert "needs 3.0 GiB of memory, 2.0 GB of disk and about" in first
    assert f"left={minutes // 60:.0f} h" in rest or f"left={int(minutes)} min" in rest


def test_a_machine_with_less_memory_is_told_so_and_the_cure_works_in_the_same_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_capture(tmp_path / "capture")
    command = ["train", str(tmp_path / "capture"), "--out", str(tmp_path / "run")]
    monkeypatch.setattr(hgs_core.runs.stages, "STAGES", {})
    monkeypatch.setenv("HGS_MEMORY_MIB", "128")
    assert main(command) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"hgs: memory: the training needs .* GiB of memory, and 0\.1 GiB are free; .*", line)
    monkeypatch.setenv("HGS_MEMORY_MIB", "65536")
    assert main([*command, "--preset", "preview"]) == 0


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
