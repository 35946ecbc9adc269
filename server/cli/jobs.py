"""`hgs jobs`: list, look at, follow, cancel, retry and delete the jobs of the service's home, or of a server."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from server.cli.job_words import job_details, job_table, no_worker, since, worker_table
from server.cli.progress_bars import ProgressBars
from server.cli.server_client import add_patience_option

if TYPE_CHECKING:
    from server.cli.job_desk import JobDesk

__all__ = ["add_parser"]

POLL_SECONDS = 0.5
PAGE = 1000  # jobs that are asked for at once
MOST_LINES = 1000


def add_parser(commands: Any) -> None:
    """Add the subcommand and its own subcommands."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "jobs", help="list, follow, cancel, retry and delete jobs", description="Look after jobs."
    )
    actions = parser.add_subparsers(metavar="ACTION", required=True)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--to", metavar="URL", help="a server, as in http://host:8000; default: HGS_HOME here")
    add_patience_option(common)
    common.add_argument("--json", action="store_true", help="print JSON, as the REST interface answers")

    listing = _action(actions, common, "ls", "list jobs: those that run, those that wait, those that are finished", _ls)
    listing.add_argument("--state", choices=("queued", "running", "waiting", "succeeded", "failed", "cancelled"))
    listing.add_argument("--label", action="append", default=[], help="only jobs with this label; may be repeated")
    listing.add_argument("--capture", help="only jobs of this capture: its absolute path")
    listing.add_argument("--find", metavar="TEXT", help="only jobs with this text in their title or id")
    listing.add_argument("--since", metavar="WHEN", help="submitted since then: 12h, 3d, or a date as 2026-11-22")
    listing.add_argument("--limit", type=int, default=100, help="at most so many jobs; default: %(default)s")

    _with_job(_action(actions, common, "show", "show one job", _show))
    _with_job(_action(actions, common, "watch", "follow a job to its end; the exit status tells how it went", _watch))
    logs = _with_job(_action(actions, common, "logs", "print the end of a job's log", _logs))
    logs.add_argument("--lines", type=int, default=100, help="so many lines, at most 1000; default: %(default)s")
    for name, what in (("cancel", "cancel jobs"), ("retry", "queue failed or cancelled jobs again")):
        _with_jobs(_action(actions, common, name, what, _act)).set_defaults(action=name)
    delete = _with_jobs(_action(actions, common, "delete", "forget finished jobs and remove their files", _delete))
    delete.add_argument("--scene", action="store_true", help="also take back the scenes that they published")
    _action(actions, common, "workers", "list the workers, and what each does", _workers)


def _action(actions: Any, common: argparse.ArgumentParser, name: str, what: str, run: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        name, help=what, description=f"{what[0].upper()}{what[1:]}.", parents=[common]
    )
    parser.set_defaults(run=lambda options: _at_desk(run, options))
    return parser


def _with_job(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    parser.add_argument("job", metavar="JOB", help="the job's id")
    return parser


def _with_jobs(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    parser.add_argument("jobs", metavar="JOB", nargs="+", help="ids of jobs")
    return parser


def _at_desk(run: Any, options: argparse.Namespace) -> int:
    from jobs.home.home import Home
    from server.cli.job_desk import HomeDesk, ServerDesk

    there = options.to is not None
    with ServerDesk(options.to, options.patience) if there else HomeDesk(Home.from_environment()) as desk:
        status: int = run(desk, options)
        return status


def _ls(desk: JobDesk, options: argparse.Namespace) -> int:
    if options.limit < 1:
        raise InputError("--limit", f"{options.limit} is too few", "give 1 or more")
    jobs = list(_listed(desk, options))
    if options.json:
        _print_json({"jobs": jobs})
    else:
        print(job_table(jobs, time.time()))
        waiting = [job for job in jobs if job["state"] == "queued"]
        if waiting and (line := no_worker(waiting, desk.workers()["workers"], options.to or "")):
            print(line, file=sys.stderr)
    return 0


def _listed(desk: JobDesk, options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    query = [(name, value) for name in ("state", "capture", "find") if (value := getattr(options, name))]
    query += [("label", label) for label in options.label]
    if options.since:
        query.append(("since", f"{max(0.0, since(options.since, '--since')):.3f}"))
    left, after = options.limit, None
    while left > 0:
        more: list[tuple[str, str]] = [("after", after)] if after else []
        page = desk.page([*query, ("limit", str(min(left, PAGE))), *more])
        yield from page["jobs"]
        left, after = left - len(page["jobs"]), page["next"]
        if after is None:
            return


def _show(desk: JobDesk, options: argparse.Namespace) -> int:
    job = desk.job(options.job)
    if options.json:
        _print_json(job)
    else:
        print(job_details(job, time.time()))
    return 0


def _watch(desk: JobDesk, options: argparse.Namespace) -> int:
    with ProgressBars() as bars:
        told: dict[str, Any] | None = None
        while True:
            job = desk.job(options.job)
            progress = job["progress"]
            if options.json and job != told:
                print(json.dumps(job), flush=True)
            elif progress is not None and not options.json:
                left = job["ends"] and job["ends"] - time.time()
                bars(Progress(progress["stage"], progress["done"], progress["total"], progress["figures"]), left)
            told = job
            if job["state"] not in ("queued", "running", "waiting"):
                break
            time.sleep(POLL_SECONDS)
    if job["state"] != "succeeded":
        print(f"hgs: job {job['id']}: {job['state']}{': ' + job['error'] if job['error'] else ''}", file=sys.stderr)
        return 1
    return 0


def _logs(desk: JobDesk, options: argparse.Namespace) -> int:
    if not 1 <= options.lines <= MOST_LINES:
        raise InputError("--lines", f"{options.lines} is out of range", f"give 1 to {MOST_LINES}")
    told = desk.log(options.job, options.lines)
    if options.json:
        _print_json(told)
    else:
        print(*told["lines"], sep="\n")
    return 0


def _act(desk: JobDesk, options: argparse.Namespace) -> int:
    jobs = [desk.act(job_id, options.action) for job_id in options.jobs]
    if options.json:
        _print_json({"jobs": jobs})
    else:
        print(job_table(jobs, time.time()))
    return 0


def _delete(desk: JobDesk, options: argparse.Namespace) -> int:
    for job_id in options.jobs:
        desk.delete(job_id, scene=options.scene)
    if options.json:
        _print_json({"deleted": options.jobs})
    return 0


def _workers(desk: JobDesk, options: argparse.Namespace) -> int:
    found = desk.workers()
    if options.json:
        _print_json(found)
    else:
        print(worker_table(found["workers"], time.time()))
        print(f"{found['busy']} of {found['slots']} slots are in use")
    return 0


def _print_json(value: Any) -> None:
    print(json.dumps(value, indent=1, allow_nan=False))
