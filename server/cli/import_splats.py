"""`hgs import FILE --out RUN`: makes a run of a file of splats."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.writable import require_writable_folder
from hgs_core.fit.fit_config import BUDGETS
from hgs_core.runs.run_config import RunConfig
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "import",
        help="make a run of a file of splats",
        description="Make a run of a .ply (3DGS, STGS), .splat, .spz, .glb, .sog or .4dgs file, or of .ply frames; "
        "encode it.",
    )
    parser.add_argument(
        "file", metavar="FILE|FOLDER", type=Path, help="the file; its suffix tells the format. A folder: .ply frames"
    )
    parser.add_argument("--out", metavar="RUN", type=Path, required=True, help="new folder of the run")
    parser.add_argument(
        "--capture",
        metavar="FOLDER",
        type=Path,
        help="what the splats were made of, in the same world: encoding is measured on it, and the run can be scored",
    )
    parser.add_argument("--hold-out", metavar="A,B", default="", help="cameras that encoding must not look at")
    parser.add_argument("--duration", metavar="S", type=float, help="seconds that a 4D file lasts (default: 50 / 30)")
    parser.add_argument("--fps", metavar="N", type=float, help="frames of a folder a second (default: 30)")
    parser.add_argument(
        "--antialiased",
        action=argparse.BooleanOptionalAction,
        help="whether the splats were trained antialiased (default: as the file or --capture tells, else not)",
    )
    parser.add_argument(
        "--activated",
        action=argparse.BooleanOptionalAction,
        help="whether scales and opacities stand in a .ply as they are drawn, not as logarithms and logits (default: "
        "their ranges tell)",
    )
    parser.add_argument("--budget", choices=list(BUDGETS), default="default", help="what encoding may lose")
    parser.add_argument("--json", metavar="FILE", help="write what is left out or changed as JSON; -: in place of text")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    hold_out = [name.strip() for name in options.hold_out.split(",") if name.strip()]
    output = JsonOutput(options.json)
    require_writable_folder(options.out)
    config = RunConfig.from_json({"preset": "imported", "capture.hold_out": hold_out, "encode.budget": options.budget})
    from hgs_core.runs.imported import import_run

    with ProgressBars() as bars:
        imported = import_run(
            options.file,
            options.out,
            bars,
            duration=options.duration,
            frame_rate=options.fps,
            capture=options.capture,
            config=config,
            antialiased=options.antialiased,
            activated=options.activated,
        )
    for change in imported.changes:
        print(f"{options.file}: {change}", file=sys.stderr)
    output.show({"run": str(options.out), **imported.to_json()}, str(options.out))
    return 0
