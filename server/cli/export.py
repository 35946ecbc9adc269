"""`hgs export RUN --to FILE`: writes a scene in another format."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.writable import require_writable_file, require_writable_folder
from server.cli.frame_rate import frame_rate
from server.cli.json_output import JsonOutput
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "export",
        help="write a scene in another format",
        description="Write a scene as .ply (3DGS, STGS), .splat, .splatv, .spz, .sog, .glb, .4dgs, .usd, or frames.",
    )
    parser.add_argument("source", metavar="RUN|SCENE", type=Path, help="folder of a run, or of an encoded scene")
    parser.add_argument(
        "--to",
        metavar="FILE|FOLDER",
        type=Path,
        required=True,
        help="the file; its suffix tells the format. Without: a folder of frames",
    )
    parser.add_argument("--time", metavar="S", type=float, help="write the scene as it stands at this second")
    parser.add_argument(
        "--fps",
        metavar="N",
        help="frames (folder) or samples (.usd) a second (default: the capture's)",
    )
    parser.add_argument("--frames", metavar="FORMAT", help="of a folder: ply (default) or sog")
    parser.add_argument("--segment", metavar="N", type=int, help="which segment of several a 4D file holds, from 0")
    parser.add_argument("--spz-version", metavar="N", type=int, help="of .spz: 2, 3 (default) or 4")
    parser.add_argument(
        "--bake",
        action="store_true",
        help="make splats as soft as the training pictures, for viewers without antialiasing",
    )
    parser.add_argument("--json", metavar="FILE", help="write what the file lacks as JSON; -: in place of text")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.runs.source import open_source

    rate = None if options.fps is None else float(frame_rate(options.fps))
    output = JsonOutput(options.json)
    (require_writable_file if options.to.suffix else require_writable_folder)(options.to)
    source = open_source(options.source)
    with ProgressBars() as bars:
        changes = source.export(
            options.to,
            time=options.time,
            segment=options.segment,
            version=options.spz_version,
            frame_rate=rate,
            frames=options.frames,
            bake=options.bake,
            progress=bars,
        )
    for change in changes:
        print(f"{options.to}: {change}", file=sys.stderr)
    output.show({"file": str(options.to), "changes": [change.to_json() for change in changes]}, str(options.to))
    return 0
