"""Soak a whole service in random faults, and hold it to its promises: scripts/soak --minutes N --seed S.

API, two workers, Postgres and S3 run behind doors that fail, while clients upload, submit, cancel, retry, publish,
rename, delete, watch and rotate keys. Every request is noted; afterwards the service must have kept every promise.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.refusals import refusing
from benchmarks.soak.planted_bugs import Bug
from benchmarks.soak.soaked_service import Extras
from benchmarks.soak.stepped_clock import compiler
from hgs_core.base.errors import InputError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the soak and return the exit status: 1 where a promise was broken or something grew."""
    parser = argparse.ArgumentParser(prog="scripts/soak", description=__doc__)
    parser.add_argument(
        "--minutes", metavar="N", type=float, default=5.0, help="of faults (default: 5; 8 show leaks of memory)"
    )
    parser.add_argument("--seed", metavar="S", type=int, default=1, help="decides faults and requests (default: 1)")
    parser.add_argument("--out", metavar="FOLDER", type=Path, help="new folder of the report (default: temporary)")
    parser.add_argument("--old-workers", metavar="REVISION", default="", help="let one worker be of this revision")
    parser.add_argument("--bug", choices=list(Bug), type=Bug, help="plant a deliberate bug, which must be found")
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))  # nothing may stay behind
    return refusing(lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    if not 0 < options.minutes <= 24 * 60:
        raise InputError("--minutes", f"{options.minutes} is not a length", "give a number above 0, at most 1440")
    if options.out is not None and options.out.exists():
        raise InputError("--out", f"{options.out} is there already", "name a new folder")
    folder = Path(tempfile.mkdtemp(prefix="hgs-soak-")) if options.out is None else options.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(0o755)  # Postgres runs as another user where this runs as root
    from benchmarks.soak.soak_run import soak

    extras = Extras(options.bug, options.old_workers, small_disk=_may_mount(), clocks=bool(compiler()))
    result = soak(folder, options.seed, options.minutes, extras)
    print("\n".join(result.lines()))
    return 0 if result.sound else 1


def _may_mount() -> bool:
    if os.geteuid() != 0:
        return False
    with tempfile.TemporaryDirectory() as folder:
        tried = subprocess.run(["mount", "-t", "tmpfs", "tmpfs", folder], capture_output=True, check=False)
        if tried.returncode == 0:
            subprocess.run(["umount", folder], check=True)
        return tried.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
