"""How long a whole training takes on a device, and how good the scene is that comes out."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.evaluate.run import evaluate_run
from hgs_core.native.machine import machine_facts
from hgs_core.render.backends import training_device
from hgs_core.runs.creation import create_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.stages import STAGES

__all__ = ["DEVICES", "TrainingReport", "bench_training", "training_report_text"]

DEVICES = {"cpu": "auto", "cuda": "triton"}
"""Device -> the backend that trains there."""


@dataclass(frozen=True)
class TrainingReport:
    """One training; PSNR and SSIM are of the encoded scene on the held-out cameras."""

    machine: Mapping[str, str | int | float | None]
    device: str
    config: Mapping[str, Any]
    minutes: float  # minutes of the stage `train`
    minutes_in_all: float  # initialisation, training and encoding
    profile: Mapping[str, float]  # seconds of training by activity
    psnr: float  # dB
    ssim: float
    bytes_total: int
    splats_static: int
    splats_dynamic: int

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
        for stage in STAGES.values():
            stage(run, progress)
        seconds = time.monotonic() - started
        scores = evaluate_run(run, progress, backend=backend)
        summary = json.loads(RunFolder(run).train_summary.read_text())
    return TrainingReport(
        machine_facts(),
        device,
        config.to_json(),
        summary["seconds"] / 60,
        seconds / 60,
        summary["profile"],
        scores["psnr"],
        scores["ssim"],
        scores["bytes_total"],
        scores["splats_static"],
        scores["splats_dynamic"],
    )


def training_report_text(report: TrainingReport) -> str:
    """Return the report as lines for people."""
    longest = sorted(report.profile.items(), key=lambda item: -item[1])
    return "\n".join(
        (
            f"device {report.device}, {report.machine['cpu']}, torch {report.machine['torch']}",
            f"training {report.minutes:.2f} min, with initialisation and encoding {report.minutes_in_all:.2f} min",
            f"PSNR {report.psnr:.2f} dB, SSIM {report.ssim:.4f}, {report.bytes_total:,} bytes",
            f"{report.splats_static:,} static and {report.splats_dynamic:,} dynamic splats",
            "seconds: " + ", ".join(f"{name} {seconds:.1f}" for name, seconds in longest),
        )
    )
