"""`hgs ablate CAPTURE --hold-out CAMS --out FOLDER`: the value of each part of the method on a capture."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped
from hgs_core.base.writable import require_writable_folder
from server.cli.interrupts import Interrupts
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_training_options, training_config

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "ablate",
        help="train and score with parts of the method changed",
        description="Train and score one run per row and seed, each with one thing changed (docs/evaluation.md). "
        "Run again to resume: finished runs are not repeated.",
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view capture")
    parser.add_argument("--out", metavar="FOLDER", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--rows", metavar="A,B", help="rows beside the full method; default: all")
    parser.add_argument("--seeds", metavar="N,N", help="seeds of every row; default: that of the config")
    parser.add_argument(
        "--masks", metavar="FOLDER", type=Path, help="masks to train with, instead of the capture's own"
    )
    parser.add_argument(
        "--truth", metavar="FOLDER", type=Path, help="score against these pictures, instead of the capture's"
    )
    parser.add_argument(
        "--score-masks",
        metavar="FOLDER",
        type=Path,
        help="masks of what moves in the held-out cameras, for the scores alone",
    )
    parser.add_argument(
        "--json",
        metavar="FILE",
        nargs="?",
        const="-",
        help="write JSON to FILE, or to standard output in place of the table",
    )
    add_training_options(parser, hold_out="")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.ablate.ablation_rows import rows_named
    from hgs_core.ablate.plan import Ablation

    config = training_config(options)
    ablation = Ablation(
        options.capture,
        options.out,
        config,
        rows_named(None if options.rows is None else _list("--rows", options.rows)),
        (config.seed,) if options.seeds is None else [_seed(text) for text in _list("--seeds", options.seeds)],
        masks=options.masks,
        truth=options.truth,
        score_masks=options.score_masks,
    )
    output = JsonOutput(options.json)
    require_writable_folder(options.out)
    from hgs_core.ablate.ablation import ablate
    from hgs_core.ablate.ablation_table import table_text

    with Interrupts() as interrupts, ProgressBars(interrupts) as bars:
        try:
            result = ablate(ablation, bars)
        except StageStopped:
            bars.close()
            print("stopped; run the same command again to resume", file=sys.stderr)
            return 130
    output.show(result, table_text(result))
    return 0


def _list(where: str, text: str) -> list[str]:
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise InputError(where, "names nothing", "give names with commas between them, or leave it out")
    return names


def _seed(text: str) -> int:
    if not (text.isascii() and text.isdecimal()):
        raise InputError("--seeds", f"{text!r} is not a whole number from 0")
    return int(text)
