"""Serve a scene to many viewers at once, each at the rate at which it plays: python -m benchmarks.serve.

Prints the processor time and memory of the server, and the delay of requested chunks.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.refusals import refusing
from benchmarks.serve.serve_bench import bench_serve, serve_text
from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit status."""
    parser = argparse.ArgumentParser(prog="benchmarks.serve", description=__doc__)
    parser.add_argument(
        "run_folder",
        metavar="RUN",
        type=Path,
        nargs="?",
        help="a finished run or a scene folder; default: a made-up scene, 0.96 Mbit/s of random bytes",
    )
    parser.add_argument("--minutes", metavar="M", type=float, default=1.0, help="of the made-up scene (default: 1)")
    parser.add_argument("--json", metavar="FILE", nargs="?", const="-", help="write JSON to FILE or standard output")
    parser.add_argument("--viewers", metavar="N", type=int, default=50, help="at once (default: 50)")
    parser.add_argument("--seconds", metavar="S", type=float, default=10.0, help="to watch (default: 10)")
    parser.add_argument("--processes", metavar="N", type=int, default=1, help="servers (default: 1)")
    parser.add_argument(
        "--bad-clients",
        action="store_true",
        help="then let clients misbehave: that do not read, that open connections and wait, that seek all the time",
    )
    options = parser.parse_args(arguments)
    return refusing(lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    for name in ("viewers", "processes"):
        if (number := getattr(options, name)) < 1:
            raise InputError(f"--{name}", f"{number} is too few", "give 1 or more")
    if not 0 < options.seconds < float("inf"):
        raise InputError("--seconds", f"{options.seconds} is not a time to watch", "give a number above 0")
    if not 1 / 60 <= options.minutes <= 600:
        raise InputError("--minutes", f"{options.minutes} is not a length", "give a number from 1/60 to 600")
    output, folder = JsonOutput(options.json), options.run_folder
    report = asyncio.run(
        bench_serve(
            options.viewers,
            options.seconds,
            folder=folder / "scene" if folder is not None and (folder / "scene").is_dir() else folder,
            minutes=options.minutes,
            processes=options.processes,
            bad_clients=options.bad_clients,
        )
    )
    output.show(report, serve_text(report))
    return 0


if __name__ == "__main__":
    sys.exit(main())
