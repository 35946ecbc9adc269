"""How the figures of a training are put together, without one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.bench import training_bench as training
from hgs_core.bench.training_bench import StageCost, TrainingReport, bench_training, training_report_text
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from tests.large_training import LARGE

CONFIG = RunConfig.for_preset("preview", capture={"hold_out": ["2"]})
SCORES = {
    "psnr": 27.5,
    "psnr_dynamic": 25.0,
    "ssim": 0.875,
    "ssim_dynamic": 0.75,
    "bytes_total": 1_234_567,
    "splats_static": 4_000,
    "splats_dynamic": 500,
}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Stages that only note their requests; the one that trains writes its summary."""
    told: dict[str, Any] = {"stages": []}

    def create(run: Path, capture: Path, config: RunConfig) -> None:
        run.mkdir()
        told.update(capture=capture, config=config, run=run)

    def train(run: Path, progress: ProgressCallback) -> None:
        told["stages"].append("train")
        RunFolder(run).train_summary.write_text(json.dumps({"seconds": 90.0, "profile": {"draw": 60.0, "step": 30.0}}))

    def evaluate(run: Path, progress: ProgressCallback, *, backend: str) -> dict[str, Any]:
        told["scored with"] = backend
        return SCORES

    monkeypatch.setattr(training, "create_run", create)
    monkeypatch.setattr(training, "STAGES", {"train": train, "encode": lambda run, _: told["stages"].append("encode")})
    monkeypatch.setattr(training, "evaluate_run", evaluate)
    monkeypatch.setattr(training, "_size", lambda run: LARGE)
    return told


def test_every_stage_is_run_once_in_a_folder_that_is_gone_afterwards(asked: dict[str, Any]) -> None:
    report = bench_training(Path("capture"), CONFIG, "cpu", silent)
    assert (asked["capture"], asked["stages"]) == (Path("capture"), ["train", "encode"])
    assert not asked["run"].exists()
    assert report.size == LARGE
    assert (report.minutes, report.profile) == (1.5, {"draw": 60.0, "step": 30.0})
    assert (report.psnr, report.ssim, report.bytes_total) == (27.5, 0.875, 1_234_567)
    assert (report.psnr_dynamic, report.ssim_dynamic) == (25.0, 0.75)
    assert (report.splats_static, report.splats_dynamic) == (4_000, 500)
    assert [cost.stage for cost in report.stages] == ["train", "encode", "evaluate"]
    assert all(cost.processor_seconds >= 0 and cost.most_memory > 1 << 20 for cost in report.stages)


def test_the_device_says_which_backend_trains_and_scores(asked: dict[str, Any]) -> None:
    report = bench_training(Path("capture"), CONFIG, "cpu", silent)
    told = asked["config"].train.backend, asked["scored with"], report.config["train"]["backend"]
    assert set(told) == {training.DEVICES["cpu"]}


def test_without_a_camera_to_score_on_nothing_is_trained(asked: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="--hold-out: no camera is left"):
        bench_training(Path("capture"), RunConfig.for_preset("preview"), "cpu", silent)
    assert asked["stages"] == []


def test_the_text_has_every_figure_and_the_longest_activity_first() -> None:
    machine = {"cpu": "Fast One", "torch": "2.13"}
    report = TrainingReport(
        machine,
        "cpu",
        {},
        LARGE,
        1.5,
        2.25,
        {"step": 30.0, "draw": 60.0},
        27.5,
        25.0,
        0.875,
        0.75,
        1_234_567,
        4_000,
        500,
        (StageCost("train", 90.0, 135.0, 0.75, 3 << 20),),
    )
    assert training_report_text(report).splitlines() == [
        "device cpu, Fast One, torch 2.13",
        "training 1.50 min, with initialisation and encoding 2.25 min",
        "PSNR 27.50 dB, SSIM 0.8750, 1,234,567 bytes",
        "where it moves: PSNR 25.00 dB, SSIM 0.7500",
        "4,000 static and 500 dynamic splats",
        "seconds: draw 60.0, step 30.0",
        "train: 135.0 s of processor in 90.0 s, 75% of the cores, at most 3 MiB",
    ]
