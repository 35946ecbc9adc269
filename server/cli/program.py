"""The `hgs` command line.

Exit status: 0 done; 2 bad input, or a place that cannot be read or written, told in one line on standard error; 130
stopped by Ctrl-C, 143 by SIGTERM; 141 nobody reads the output any more; 1 a fault, with a traceback.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from hgs_core.base.errors import InputError
from hgs_core.base.heap import share_heap
from hgs_core.base.own_modules import guard_imports
from hgs_core.base.system_errors import THE_OUTPUT
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
    render,
    report,
    restore,
    serve,
    submit,
    sync,
    train,
    worker,
)
from server.cli.command_line import BAD_INPUT, CommandLine
from server.cli.interrupts import Terminated, terminating
from server.cli.outer_faults import outer_fault
from server.cli.standard_streams import accept_any_text, discard_output, flush_output

__all__ = ["BAD_INPUT", "command_line", "main"]

INTERRUPTED = 130
UNREAD = 141  # the status of a program ended by SIGPIPE
TERMINATED = 143


def command_line() -> CommandLine:
    """Return the parser of all commands."""
    parser = CommandLine(prog="hgs", description="Dynamic scenes from multi-view video, streamed.")
    parser.add_argument("--version", action="version", version=f"hgs {software_version()}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (
        train,
        check,
        cameras,
        sync,
        masks,
        encode,
        evaluate,
        report,
        edit,
        publish,
        import_splats,
        export,
        render,
        serve,
        play,
        worker,
        submit,
        jobs,
        gc,
        backup,
        restore,
        keys,
        bench,
        ablate,
    ):
        command.add_parser(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status; `arguments` default to the process's own."""
    accept_any_text()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None:  # a process of its own
        guard_imports()
        share_heap()
    try:
        with terminating():
            _refuse_nul(given)
            options = command_line().parse_args(given)
            status: int = options.run(options)
            flush_output()
    except KeyboardInterrupt:
        return INTERRUPTED
    except Terminated:
        return TERMINATED
    except BrokenPipeError as error:
        if error.filename is not None:
            return _refused(error)
        discard_output()  # e.g. hgs jobs ls | head -1
        return UNREAD
    except Exception as error:
        return _refused(error)
    return status


def _refused(error: Exception) -> int:
    """Tell in one line of a fault that people can mend.

    Raises:
        Exception: the fault is the program's own.
    """
    told = outer_fault(error)
    if told is None:
        raise error
    if told.where == THE_OUTPUT:
        discard_output()
    print(f"hgs: {' '.join(str(told).split())}", file=sys.stderr)
    return BAD_INPUT


def _refuse_nul(arguments: Sequence[str]) -> None:
    for argument in arguments:
        if "\0" in argument:
            raise InputError(f"{argument[:40]!a}", "holds NUL, which no name of a file can", "leave it out")
