"""`hgs eval RUN`: scores of a finished run on its held-out cameras."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from server.progress_bars import ProgressBars

__all__ = ["FIELDS", "add_parser"]

FIELDS = (
    "psnr",  # dB, mean over frames and held-out cameras
    "ssim",  # data range 1
    "bytes_total",
    "bytes_static",
    "bytes_dynamic",
    "splats_static",
    "splats_dynamic",
    "train_seconds",
    "frames",
    "cameras",
)


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "eval", help="measure a finished run", description="Measure a finished run on the cameras it held out."
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.run_folder import RunFolder

    RunFolder(options.run_folder).read_spec()  # before torch is loaded: a wrong path is told at once
    from hgs_core.evaluate.run import evaluate_run

    with ProgressBars() as bars:
        result = evaluate_run(options.run_folder, bars)
    scores = {name: result[name] for name in FIELDS}
    if options.json:
        print(json.dumps(scores))
    else:
        for name, value in scores.items():
            print(f"{name:<15} {_text(value)}")
    return 0


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "-"
    return f"{value:.4f}" if isinstance(value, float) else str(value)
