"""`hgs gc`: removes finished jobs past their time, and the chunks that no scene names."""

from __future__ import annotations

import argparse
import dataclasses
import json
import time
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from server.cli.job_words import seconds_of

if TYPE_CHECKING:
    from jobs.artifacts.store_check import StoreCheck
    from jobs.housekeeping import Tidied

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "gc",
        help="remove old jobs, and chunks that no scene names",
        description="Tell what need not be kept in HGS_HOME and its store, and with --delete remove it. Published "
        "scenes and unfinished jobs all stay.",
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="read every chunk that a scene names, and tell which are missing or damaged; nothing is removed",
    )
    parser.add_argument("--delete", action="store_true", help="remove it; without, nothing is changed")
    parser.add_argument("--keep-jobs", metavar="N", help="keep the N finished jobs that ended last (HGS_KEEP_JOBS)")
    parser.add_argument("--keep-days", metavar="N", help="keep jobs that ended in the last N days (HGS_KEEP_DAYS)")
    parser.add_argument(
        "--keep-bytes", metavar="SIZE", help="keep as many run folders as fit into 500G or so (HGS_KEEP_BYTES)"
    )
    parser.add_argument("--every", metavar="TIME", help="do it again and again, with pauses of 1h or so")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.check:
        return _check(options)
    pause = None if options.every is None else seconds_of(options.every, "--every")
    from jobs.home.byte_sizes import bytes_of
    from jobs.home.home import Home
    from jobs.housekeeping import tidy
    from jobs.queue.client import JobClient
    from jobs.runs.retention import Retention

    retention = Retention.configured()
    for name in ("jobs", "days", "bytes"):
        given = getattr(options, f"keep_{name}")
        if given is not None:
            retention = dataclasses.replace(retention, **{name: bytes_of(given, f"--keep-{name}")})
    with JobClient(Home.from_environment()) as client:
        while True:
            tidied = tidy(client, retention, delete=options.delete)
            print(_json(tidied) if options.json else _text(tidied, delete=options.delete), flush=True)
            if pause is None:
                return 0
            time.sleep(pause)


def _check(options: argparse.Namespace) -> int:
    """Check the store; the status is 1 where something is wrong with it."""
    from jobs.artifacts.artifact_store import open_store
    from jobs.artifacts.store_check import check_store
    from jobs.home.home import Home

    if options.delete or options.every:
        raise InputError("--check", "changes nothing and runs once", "leave out --delete and --every")
    home = Home.from_environment()
    found = check_store(open_store(home))
    if options.json:
        print(json.dumps(dataclasses.asdict(found)))
    else:
        print(_check_text(found, home.store_url))
    return 0 if found.sound else 1


def _check_text(found: StoreCheck, store: str) -> str:
    lines = [f"{fault.problem}: chunks/{fault.chunk} of {', '.join(fault.scenes)}" for fault in found.faults]
    lines += [f"damaged: scenes/{scene}/manifest.json" for scene in found.unreadable]
    lines.append(f"{found.scenes} scenes name {found.chunks} chunks, {found.bytes:,} bytes; wrong: {len(lines)}")
    if not found.sound:
        lines.append(
            f"To mend it, remove what is damaged from {store} and put the same files of a backup there. Without one, "
            "delete the scene, and publish its run, if that is still there: hgs publish RUN --id SCENE"
        )
    return "\n".join(lines)


def _json(tidied: Tidied) -> str:
    return json.dumps(dataclasses.asdict(tidied))


def _text(tidied: Tidied, *, delete: bool) -> str:
    lines = [f"  {job_id}" for job_id in tidied.jobs]
    chunks = tidied.chunks
    lines += [
        f"finished jobs: {len(tidied.jobs)}, {tidied.job_bytes:,} bytes of run folders",
        f"chunks that none of {chunks.scenes} scenes names: {chunks.chunks}, {chunks.bytes:,} bytes",
        "removed" if delete else "nothing was changed: --delete removes them",
    ]
    return "\n".join(lines)
