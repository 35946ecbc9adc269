"""`hgs restore`: makes a home of a backup."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "restore",
        help="make HGS_HOME of a backup",
        description="Make HGS_HOME, which is not there yet or empty, of a folder that hgs backup has made, on this "
        "machine or another. Every file is compared with its SHA-256 first.",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="what hgs backup has made")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from jobs.backup.backup_restore import restore
    from jobs.home.home import Home

    home = Home.from_environment()
    backup = restore(options.folder, home)
    made = datetime.fromtimestamp(backup.made, UTC).isoformat(sep=" ", timespec="seconds")
    print(f"{home.folder} is the home of {made}: {backup.files} files, {backup.bytes:,} bytes; start it with hgs serve")
    return 0
