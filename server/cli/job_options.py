"""The options of a job apart from training: labels, priority, time limit, webhook."""

from __future__ import annotations

import argparse
from typing import Any

from server.cli.job_words import seconds_of

__all__ = ["add_job_options", "job_options"]


def add_job_options(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--label", action="append", default=[], help="a word to find the job by (hgs jobs ls --label); may be repeated"
    )
    parser.add_argument("--priority", type=int, default=0, help="-100 to 100: higher ones are taken first; default: 0")
    parser.add_argument("--time-limit", metavar="TIME", help="end the job when it runs for so long: 90m, 12h, 2d")
    parser.add_argument("--webhook", metavar="URL", default="", help="tell this URL when the job ends (docs/jobs.md)")
    parser.add_argument("--key", default="", help="idempotency key: the same command with it makes no second job")


def job_options(options: argparse.Namespace) -> dict[str, Any]:
    """Return them as the fields of a `JobRequest`.

    Raises:
        InputError: the time limit is no duration.
    """
    limit = 0.0 if options.time_limit is None else seconds_of(options.time_limit, "--time-limit")
    return {
        "labels": tuple(options.label),
        "priority": options.priority,
        "time_limit": limit,
        "webhook": options.webhook,
        "key": options.key,
    }
