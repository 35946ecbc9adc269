"""`hgs check CAPTURE`: whether poses, lenses, clocks, masks and pictures of a capture fit, before it trains."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped, interruptible
from hgs_core.base.writable import require_writable_file
from server.cli.interrupts import Interrupts
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_given_options

if TYPE_CHECKING:
    from hgs_core.capture.cameras.corrected_poses import CorrectedCamera
    from hgs_core.capture.capture import Capture
    from hgs_core.check.findings import CaptureCheck

__all__ = ["add_parser"]

_ROUNDS = 3  # rounds of corrections: undoing one mistake may show another


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "check",
        help="find faults of a capture before it trains",
        description="Find wrong poses, lenses, clocks, masks and pictures of a capture. hgs train does it first.",
    )
    parser.add_argument("capture", metavar="CAPTURE", type=Path, help="folder of a multi-view capture")
    add_given_options(parser)
    parser.add_argument(
        "--fix-poses",
        action="store_true",
        help="write poses without the mistakes that are found to CAPTURE/poses.json, and check again",
    )
    parser.add_argument(
        "--json", metavar="FILE", help="write the result as JSON, too; - prints it in place of the table"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.capture.cameras.corrected_poses import CORRECTIONS_FILE
    from hgs_core.check.capture_check import check_capture
    from hgs_core.check.require_sound_capture import require_sound
    from hgs_core.runs.run_config import RunConfig
    from hgs_core.runs.training_costs import training_need
    from hgs_core.runs.training_size import TrainingSize

    output = JsonOutput(options.json)
    out = options.capture / CORRECTIONS_FILE
    if options.fix_poses and out.exists():
        raise InputError(out, "is there already", "move it away to have the poses corrected again")
    capture = _opened(options)
    if options.fix_poses:
        require_writable_file(out)
    with Interrupts() as interrupts, ProgressBars(interrupts) as bars, interruptible():
        try:
            check = check_capture(capture, bars)
            if options.fix_poses:
                bars.close()
                capture, check = _fixed(options, capture, check, bars)
        except StageStopped:
            return 130
    output.show(check.to_json(), check.table())
    need = training_need(TrainingSize.of(capture, RunConfig()), RunConfig())
    print(f"hgs train {need.sentence()}, as it is set by default", file=sys.stderr)
    require_sound(check, options.capture)
    return 0


def _opened(options: argparse.Namespace) -> Capture:
    from hgs_core.capture.open import open_capture

    capture = open_capture(options.capture, masks=options.masks, depth=options.depth, mesh=options.mesh)
    for note in capture.notes:
        print(f"{options.capture}: {note}", file=sys.stderr)
    return capture


def _fixed(
    options: argparse.Namespace, capture: Capture, check: CaptureCheck, bars: ProgressBars
) -> tuple[Capture, CaptureCheck]:
    """Return the capture with its poses corrected as often as a check finds how, and the last check."""
    from hgs_core.capture.cameras.corrected_poses import write_corrections
    from hgs_core.check.capture_check import check_capture

    written: dict[str, CorrectedCamera] = {}
    because: list[str] = []
    for _ in range(_ROUNDS):
        corrected = [one for finding in check.findings for one in finding.corrected]
        if not corrected:
            break
        print(check.table(), file=sys.stderr)
        written |= {one.name: one.after(written.get(one.calibration)) for one in corrected}
        because += [finding.named() for finding in check.findings if finding.corrected]
        file = write_corrections(options.capture, "; ".join(because), written.values())
        print(f"{file} has the corrected poses, which are checked again", file=sys.stderr)
        capture = _opened(options)
        check = check_capture(capture, bars)
        bars.close()
    if not written:
        print("no fault of the poses is found that can be undone: nothing is written", file=sys.stderr)
    return capture, check
