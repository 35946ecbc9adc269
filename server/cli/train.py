"""`hgs train CAPTURE --out RUN`: from a capture to an encoded scene, in this process."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.progress import Progress, StageStopped
from hgs_core.base.writable import require_writable_folder
from server.cli.interrupts import Interrupts
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_audio_option, add_given_options, add_training_options, training_config

if TYPE_CHECKING:
    from hgs_core.check.findings import CaptureCheck
    from hgs_core.runs.training_need import TrainingNeed

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "train", help="train and encode a capture", description="Train and encode a capture. Run again to resume."
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view capture")
    parser.add_argument("--out", metavar="RUN", type=Path, required=True, help="folder of the run")
    add_given_options(parser)
    add_audio_option(parser, "auto", "default: auto")
    add_training_options(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    config = training_config(options)
    require_writable_folder(options.out)
    if config.train.backend == "triton":  # ahead of minutes of initialisation
        from hgs_core.render.backends import training_device

        training_device(config.train.backend)
    from hgs_core.runs.remaining_time import RemainingTime
    from hgs_core.runs.stages import train_scene

    with Interrupts() as interrupts, ProgressBars(interrupts) as bars:

        def show(check: CaptureCheck) -> None:
            bars.close()
            print(check.table(), file=sys.stderr)

        forecast = RemainingTime(None)

        def state(need: TrainingNeed) -> None:
            nonlocal forecast
            bars.close()
            print(f"{options.capture} {need.sentence()}", file=sys.stderr)
            forecast = RemainingTime(need)

        def report(progress: Progress) -> None:
            bars(progress, forecast.after(progress, time.monotonic()))

        try:
            train_scene(
                options.capture,
                options.out,
                config,
                masks=options.masks,
                depth=options.depth,
                mesh=options.mesh,
                audio=options.audio,
                progress=report,
                checked=show,
                needed=state,
            )
        except StageStopped:
            bars.close()
            print("stopped; run the same command again to resume", file=sys.stderr)
            return 130
    print(options.out)
    return 0
