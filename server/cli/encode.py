"""`hgs encode RUN`: encode a trained run again, with another budget."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_folder
from hgs_core.fit.fit_config import BUDGETS
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "encode",
        help="encode a trained run again",
        description="Encode a trained run in place of its encoded scene: as small as a loss of quality allows.",
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument(
        "--budget",
        choices=list(BUDGETS),
        help="of the loss on the training views, or on made-up ones if the run was imported; "
        "default: that of the run's config",
    )
    parser.add_argument(
        "--fine-tune",
        type=int,
        metavar="ITERATIONS",
        help="iterations for which the scene is trained as it decodes, so that coarser codes will do; 0: none; "
        "default: the share of the run's iterations that its config states",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.runs.encoding import encode_again
    from hgs_core.runs.run_folder import RunFolder

    if options.fine_tune is not None and options.fine_tune < 0:
        raise InputError("--fine-tune", f"{options.fine_tune} is below 0", "give a number of iterations, or 0")
    folder = RunFolder(options.run_folder)
    spec = folder.read_spec()  # ahead of loading torch, for a quick refusal
    require_writable_folder(options.run_folder)
    with folder.exclusive(), ProgressBars() as bars:
        encoded = encode_again(options.run_folder, options.budget, bars, fine_tune=options.fine_tune)
    totals = encoded.manifest.totals
    for kind, kept, before, size in (
        ("static", totals.splats_static, encoded.static, totals.bytes_static),
        ("dynamic", totals.splats_dynamic, encoded.dynamic, totals.bytes_dynamic),
    ):
        each = f", {size / kept:.1f} each" if kept else ""
        print(f"{kept:,} {kind} splats in {size:,} bytes{each}; {before - kept:,} dropped")
    if (audio := encoded.manifest.audio) is not None:
        print(f"sound: {audio.codec}, {len(audio.pieces)} pieces in {encoded.manifest.bytes_audio:,} bytes")
    views = "views made up around the splats" if spec.without_capture else "training views"
    share, moving = encoded.dynamic_share, encoded.loss.moving
    of_dynamic = "" if share == 1 else f", {share * encoded.coarseness:.3g} of dynamic splats"
    where = "" if moving is None else f", {moving:.3f} dB where it moves"
    print(f"coarseness {encoded.coarseness:.3g}{of_dynamic}, {encoded.loss.whole:.3f} dB lost in {views}{where}")
    print(folder.scene)
    return 0
