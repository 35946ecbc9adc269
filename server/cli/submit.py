"""`hgs submit CAPTURE`: queues a job in the service's home, or sends the capture to a server elsewhere."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from hgs_core.base.progress import Progress
from server.cli.job_options import add_job_options, job_options
from server.cli.job_words import no_worker
from server.cli.progress_bars import ProgressBars
from server.cli.server_client import add_patience_option
from server.cli.training_options import add_audio_option, add_given_options, add_training_options, training_config

__all__ = ["add_parser"]

POLL_SECONDS = 0.5


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "submit",
        help="queue a capture for training",
        description="Queue a capture for training; print the job's id. With --to, send it to a server first; run the "
        "same command again to go on with what was cut off.",
    )
    parser.add_argument(
        "capture",
        metavar="CAPTURE",
        type=Path,
        help="folder of a multi-view capture; with --to also a .zip, .tar, .tar.gz or .tar.zst of one",
    )
    parser.add_argument("--to", metavar="URL", help="a server to send the capture to, as in http://host:8000")
    parser.add_argument("--title", default="", help="for people; default: the capture's name")
    parser.add_argument(
        "--wait", action="store_true", help="follow the job to its end; the exit status tells how it went"
    )
    add_patience_option(parser)
    add_job_options(parser)
    add_given_options(parser)
    add_audio_option(parser, "auto", "default: auto")
    add_training_options(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    config = training_config(options)
    if options.to is not None:
        from server.cli.submit_to_server import submit_to_server

        return submit_to_server(options)
    from hgs_core.runs.given_files import GivenFiles
    from hgs_core.runs.sound import require_sound_file
    from jobs.home.home import Home
    from jobs.queue.client import JobClient
    from jobs.queue.job_request import JobRequest

    request = JobRequest(
        options.capture,
        config,
        options.title,
        GivenFiles(options.masks, options.depth, options.mesh, require_sound_file(options.audio)),
        **job_options(options),
    )
    with JobClient(Home.from_environment()) as client:
        job_id = client.submit(request)
        print(job_id, flush=True)
        if line := no_worker([{"state": "queued"}], client.workers()):
            print(line, file=sys.stderr)
        return _follow(client, job_id) if options.wait else 0


def _follow(client: Any, job_id: str) -> int:
    """Draw the job's progress until it is finished; return 0 if it succeeded."""
    with ProgressBars() as bars:
        while not (job := client.get(job_id)).state.finished:
            if job.stage:
                left = job.ends - time.time() if job.ends else None
                bars(Progress(job.stage, job.done, job.total, job.figures), left)
            time.sleep(POLL_SECONDS)
    if job.state != "succeeded":
        print(f"hgs: job {job_id}: {job.state.value}{': ' + job.error if job.error else ''}", file=sys.stderr)
        return 1
    return 0
