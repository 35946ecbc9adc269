"""`hgs check CAPTURE`: whether poses, lenses, clocks, masks and pictures of a capture fit, before it trains."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.progress import StageStopped, interruptible
from server.cli.interrupts import Interrupts
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_masks_option

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "check",
        help="find faults of a capture before it trains",
        description="Find wrong poses, lenses, clocks, masks and pictures of a capture. hgs train does it first.",
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view capture")
    add_masks_option(parser)
    parser.add_argument(
        "--json", metavar="FILE", help="write the result as JSON, too; - prints it in place of the table"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.capture.open import open_capture
    from hgs_core.check.capture_check import check_capture
    from hgs_core.check.require_sound_capture import require_sound

    output = JsonOutput(options.json)
    capture = open_capture(options.capture, masks=options.masks)
    for note in capture.notes:
        print(f"{options.capture}: {note}", file=sys.stderr)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars, interruptible():
        try:
            check = check_capture(capture, bars)
        except StageStopped:
            return 130
    output.show(check.to_json(), check.table())
    require_sound(check, options.capture)
    return 0
