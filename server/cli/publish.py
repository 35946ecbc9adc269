"""`hgs publish RUN`: puts the scene of a finished run into the store of the service."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from server.cli.progress_bars import ProgressBars

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "publish", help="publish a finished run", description="Publish a finished run and print the scene's id."
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument("--id", default="", help="the scene's id; default: the name of the run's folder")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from jobs.artifacts import ArtifactStore
    from jobs.home import Home
    from server.publishing import publish_run

    with ProgressBars() as bars:
        scene_id = publish_run(ArtifactStore(Home.from_environment().store_url), options.run_folder, options.id, bars)
    print(scene_id)
    return 0
