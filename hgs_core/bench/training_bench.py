"""How long a whole training takes on a device, and how good the scene is that comes out."""

from __future__ import annotations

import dataclasses
import json
import resource
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hgs_core.base.cores import core_count
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.evaluate.run import evaluate_run
from hgs_core.native.machine import machine_facts
from hgs_core.render.backends import training_device
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import STAGES
from hgs_core.runs.training_size import TrainingSize

__all__ = ["DEVICES", "StageCost", "TrainingReport", "bench_training", "training_report_text"]

DEVICES = {"cpu": "auto", "cuda": "triton"}
"""Device -> the backend that trains there."""


@dataclass(frozen=True)
class StageCost:
    """The cost of one stage in this process."""

    stage: str  # reported name: `frames`, `masks` and `points` are parts of `initialise`
    seconds: float  # seconds of the clock
    processor_seconds: float  # seconds of all threads
    cores_used: float  # share of the cores, 0 to 1
    most_memory: int  # bytes that the process has had at once up to the stage's end


@dataclass(frozen=True)
class TrainingReport:
    """One training; PSNR and SSIM are of the encoded scene on the held-out cameras."""

    machine: Mapping[str, str | int | float | None]
    device: str
    config: Mapping[str, Any]
    size: TrainingSize
    minutes: float  # minutes of the stage `train`
    minutes_in_all: float  # initialisation, training and encoding
    profile: Mapping[str, float]  # seconds of training by activity
    psnr: float  # dB
    psnr_dynamic: float | None  # dB of moving pixels, None where nothing moves
    ssim: float
    ssim_dynamic: float | None
    bytes_total: int
    splats_static: int
    splats_dynamic: int
    stages: tuple[StageCost, ...]  # stages in their order, and scoring

    def to_json(self) -> dict[str, Any]:
        """Return plain dictionaries, lists, strings and numbers."""
        return dataclasses.asdict(self)


def bench_training(capture: Path, config: RunConfig, device: str, progress: ProgressCallback) -> TrainingReport:
    """Train and score a capture in a temporary folder.

    Raises:
        InputError: no camera is held out, the device is not there, or the capture is unusable.
    """
    if not config.capture.hold_out:
        raise InputError("--hold-out", "no camera is left to score on", "name one or more")
    backend = DEVICES[device]
    training_device(backend)
    config = config.changed({"train.backend": backend})
    with TemporaryDirectory(prefix="hgs-bench-") as folder:
        run = Path(folder) / "run"
        started = time.monotonic()
        create_run(run, capture, config)
        costs = [cost for name, stage in STAGES.items() for cost in _costs(name, partial(stage, run), progress)]
        seconds = time.monotonic() - started
        scores: dict[str, Any] = {}
        costs += _costs("evaluate", lambda report: scores.update(evaluate_run(run, report, backend=backend)), progress)
        summary = json.loads(RunFolder(run).train_summary.read_text())
        size = _size(run)
    return TrainingReport(
        machine_facts(),
        device,
        config.to_json(),
        size,
        summary["seconds"] / 60,
        seconds / 60,
        summary["profile"],
        scores["psnr"],
        scores["psnr_dynamic"],
        scores["ssim"],
        scores["ssim_dynamic"],
        scores["bytes_total"],
        scores["splats_static"],
        scores["splats_dynamic"],
        tuple(costs),
    )


def _size(run: Path) -> TrainingSize:
    spec = RunFolder(run).read_spec()
    return TrainingSize.of(spec.open_capture(), spec.config)


def _costs(name: str, work: Callable[[ProgressCallback], object], progress: ProgressCallback) -> list[StageCost]:
    """Return the costs of a stage's parts as it reports them, from one's first report to the next one's."""
    costs: list[StageCost] = []
    part, clock, processor = "", time.monotonic(), time.process_time()

    def end(following: str) -> None:
        nonlocal part, clock, processor
        if part:
            seconds, used = time.monotonic() - clock, time.process_time() - processor
            costs.append(StageCost(part, seconds, used, used / max(seconds, 1e-9) / core_count(), _most_memory()))
            clock, processor = clock + seconds, processor + used
        part = following

    def report(step: Progress) -> None:
        if step.stage != part:
            end(step.stage)
        progress(step)

    work(report)
    part = part or name
    end("")
    return costs


def _most_memory() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def training_report_text(report: TrainingReport) -> str:
    """Return the report as lines for people."""
    longest = sorted(report.profile.items(), key=lambda item: -item[1])
    moving = []
    if report.psnr_dynamic is not None and report.ssim_dynamic is not None:
        moving = [f"where it moves: PSNR {report.psnr_dynamic:.2f} dB, SSIM {report.ssim_dynamic:.4f}"]
    return "\n".join(
        (
            f"device {report.device}, {report.machine['cpu']}, torch {report.machine['torch']}",
            f"training {report.minutes:.2f} min, with initialisation and encoding {report.minutes_in_all:.2f} min",
            f"PSNR {report.psnr:.2f} dB, SSIM {report.ssim:.4f}, {report.bytes_total:,} bytes",
            *moving,
            f"{report.splats_static:,} static and {report.splats_dynamic:,} dynamic splats",
            "seconds: " + ", ".join(f"{name} {seconds:.1f}" for name, seconds in longest),
            *(
                f"{cost.stage}: {cost.processor_seconds:.1f} s of processor in {cost.seconds:.1f} s,"
                f" {cost.cores_used:.0%} of the cores, at most {cost.most_memory / 2**20:.0f} MiB"
                for cost in report.stages
            ),
        )
    )
