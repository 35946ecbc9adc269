"""`hgs worker`: takes jobs from the queue, one at a time, until it is stopped."""

from __future__ import annotations

import argparse
import logging
from typing import Any

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "worker", help="run queued jobs", description="Run queued jobs, one at a time, until stopped."
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from jobs.home.home import Home
    from jobs.worker import run_worker

    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    run_worker(Home.from_environment())
