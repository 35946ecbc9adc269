"""The `hgs` command line.

Exit status: 0 done; 2 bad input, told in one line on standard error; 130 stopped by Ctrl-C; 1 a fault, with a
traceback.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from hgs_core.base.errors import InputError
from hgs_core.base.own_modules import guard_imports
from hgs_core.base.version import software_version
from server.cli import (
    ablate,
    backup,
    bench,
    cameras,
    check,
    edit,
    encode,
    evaluate,
    export,
    gc,
    import_splats,
    jobs,
    keys,
    masks,
    play,
    publish,
    report,
    restore,
    serve,
    submit,
    sync,
    train,
    worker,
)

__all__ = ["main"]

BAD_INPUT = 2
INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status; `arguments` default to the process's own."""
    parser = argparse.ArgumentParser(prog="hgs", description="Dynamic scenes from multi-view video, streamed.")
    parser.add_argument("--version", action="version", version=f"hgs {software_version()}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (
        train, check, cameras, sync, masks, encode, evaluate, report, edit, publish, import_splats, export, serve,
        play, worker, submit, jobs, gc, backup, restore, keys, bench, ablate,
    ):  # fmt: skip
        command.add_parser(commands)
    options = parser.parse_args(arguments)
    if arguments is None:  # a process of its own
        guard_imports()
    try:
        status: int = options.run(options)
    except InputError as error:
        print(f"hgs: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    return status
