"""`hgs export RUN --to FILE`: writes a scene in another format."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "export",
        help="write a scene in another format",
        description="Write a scene as .ply (3DGS, or STGS where it moves), .splat, .splatv or .spz.",
    )
    parser.add_argument("source", metavar="RUN|SCENE", type=Path, help="folder of a run, or of an encoded scene")
    parser.add_argument("--to", metavar="FILE", type=Path, required=True, help="the file; its suffix tells the format")
    parser.add_argument("--time", metavar="S", type=float, help="write the scene as it stands at this second")
    parser.add_argument("--segment", metavar="N", type=int, help="which segment of several a 4D file holds, from 0")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.runs.source import open_source

    source = open_source(options.source)
    notes = source.export(options.to, time=options.time, segment=options.segment)
    for note in notes:
        print(f"{options.to}: {note}", file=sys.stderr)
    print(options.to)
    return 0
