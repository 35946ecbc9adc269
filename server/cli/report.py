"""`hgs report RUN`: a finished run as one HTML page."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from hgs_core.base.writable import require_writable_file, require_writable_folder
from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "report",
        help="write a page about a finished run",
        description="Write one HTML page about a finished run: pictures, errors, curves, sizes and times.",
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument("--out", metavar="FILE", type=Path, help="the page (default: RUN/report.html)")
    parser.add_argument(
        "--against", metavar="RUN", type=Path, nargs="+", default=[], help="other runs to compare speed and size with"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from hgs_core.runs.run_folder import RunFolder

    out = options.out or options.run_folder / "report.html"
    for run in map(RunFolder, (options.run_folder, *options.against)):
        run.read_spec()  # ahead of loading torch, for a quick refusal
        if not run.evaluation.exists():  # it is measured first
            require_writable_folder(run.path)
    require_writable_file(out)
    from hgs_core.report.write import write_report

    with ProgressBars() as bars:
        write_report(options.run_folder, out, options.against, bars)
    print(out)
    return 0
