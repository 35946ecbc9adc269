"""`hgs backup`: copies the home of a server, which may run."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jobs.backup.home_backup import Backup

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "backup",
        help="copy HGS_HOME, also while its server runs",
        description="Copy HGS_HOME with its database, scenes, runs, uploads and keys into a new folder, also while its "
        "server and workers run. hgs restore makes a home of it again.",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="a new folder; it appears whole or not at all")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from jobs.backup.home_backup import back_up
    from jobs.home.home import Home

    made = back_up(Home.from_environment(), options.folder)
    print(f"{options.folder}: {made.files} files, {made.bytes:,} bytes of {made.home}")
    for line in _left_out(made):
        print(line)
    if made.holes:
        print(
            f"hgs: the home itself lacks {len(made.holes)} chunks of its scenes; hgs gc --check names them",
            file=sys.stderr,
        )
    return 1 if made.holes else 0


def _left_out(made: Backup) -> list[str]:
    """Return the parts of a home that need a copy by their own tools."""
    lines = []
    if made.database != "sqlite":
        lines.append(
            "not in it: the database; copy it at about the same time: pg_dump --format=custom DATABASE > jobs.dump"
        )
    if made.store != "folder":
        lines.append(f"not in it: {shlex.quote(made.store)}; keep versions of its objects, or copy the bucket")
    return lines
