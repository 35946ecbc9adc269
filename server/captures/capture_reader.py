"""Reader process for untrusted captures: `python -P -m server.captures.capture_reader OPERATION NOTE`.

It has the limits of a stage and narrower ones, and a sandbox, so a hostile file can only crash or fill this process.
It communicates with the server as follows:

- stdin: one line of JSON, the request; when it closes, the server is gone and the process exits at once;
- stdout: lines of JSON, the answers;
- the file descriptor NOTE: the path of the file opened last, so that the server can name it if it ends the process.

The operations are `find` (list the captures), `describe` (read their lists and headers), `pictures` (of the cameras of
one) and `create` (the start of a run: all checks of a capture before there is a job).
"""

from __future__ import annotations

import errno
import importlib
import json
import logging
import os
import resource
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, NoReturn

from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from jobs.home.home import Home
from jobs.process.limited import limit_stage
from jobs.process.memory_limit import out_of_memory
from jobs.process.parent_process import when_parent_is_gone
from jobs.process.sandbox import enter_sandbox, with_links
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_readers import NOTE_BYTES
from server.http.problem_error import ProblemError

__all__ = ["STAGE", "main"]

STAGE = "initialise"  # the stage of a job that has the same limits
_MEMORY = 4 << 30  # bytes, unless HGS_STAGE_MEMORY is set
_NICENESS = 10  # viewers come first
_ORPHANED = 70
_OF_THE_SERVER = (errno.ENOSPC, errno.EDQUOT)  # the server's faults, not the capture's

_last_opened = b""

log = logging.getLogger("hgs.server")


def main(arguments: list[str] | None = None) -> int:
    """Run the operation of the command line on the request from stdin, and return the exit status."""
    operation, note = arguments or sys.argv[1:]
    home = Home.from_environment()
    limit_stage(home, STAGE)
    if home.limits.memory is None:
        _limit(resource.RLIMIT_DATA, _MEMORY)
    os.nice(_NICENESS)
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # redirects the prints of libraries
    request = json.loads(_first_line() or _end())
    enter_sandbox(*_places(operation, request))
    when_parent_is_gone(_end)
    _note_files(int(note))
    for answer in _OPERATIONS[operation](request, home):
        _send(answers, answer)
    return 0


def _first_line() -> bytes:
    """Return the request, b"" if the server is gone; no thread reads it, since there may be none before the sandbox."""
    line = b""
    while not line.endswith(b"\n"):
        data = os.read(0, 4096)
        if not data:
            return b""
        line += data
    return line


def _places(operation: str, request: dict[str, Any]) -> tuple[list[Path], list[Path]]:
    """Return the files and folders that an operation may read, and those that it may write."""
    if operation == "create":
        folders = Path(request["capture"]), *GivenFiles.from_json(request).places
        return [place for folder in folders for place in with_links(folder)], [Path(request["run"])]
    return list(CaptureFolders.from_json(request).readable), []


def _find(request: dict[str, Any], home: Home) -> Iterator[dict[str, Any]]:
    from server.captures.capture_outlines import find_captures

    found, complete = find_captures(CaptureFolders.from_json(request))
    captures = [
        {
            "name": one.name,
            "capture": str(one.path),
            "mark": one.mark,
            "layout": one.layout,
            "cameras": list(one.cameras),
        }
        for one in found
    ]
    yield {"captures": captures, "complete": complete}


def _describe(request: dict[str, Any], home: Home) -> Iterator[dict[str, Any]]:
    from server.captures.capture_outlines import describe_capture

    folders = CaptureFolders.from_json(request)
    for capture in request["captures"]:
        _limit_processor(request["seconds"])
        yield _told(lambda path=Path(capture): describe_capture(path, folders))  # type: ignore[misc]


def _pictures(request: dict[str, Any], home: Home) -> Iterator[dict[str, Any]]:
    from server.captures.capture_outlines import camera_pictures

    _limit_processor(request["seconds"])
    pictures = camera_pictures(Path(request["capture"]), CaptureFolders.from_json(request))
    while (answer := _told(lambda: next(pictures, {}))).get("found") != {}:
        yield answer
        if "found" not in answer:
            return


def _create(request: dict[str, Any], home: Home) -> Iterator[dict[str, Any]]:
    from hgs_core.runs.run_config import RunConfig
    from server.captures.capture_outlines import require_bounded_tables

    def create() -> dict[str, Any]:
        capture = Path(request["capture"])
        require_bounded_tables(capture)
        pipeline = importlib.import_module(home.pipeline)
        config, given = RunConfig.from_json(request["config"]), GivenFiles.from_json(request)
        config = pipeline.create_run(Path(request["run"]), capture, config, given)
        return {"config": config.to_json()}

    _limit_processor(request["seconds"])
    yield _told(create)


_OPERATIONS: dict[str, Callable[[dict[str, Any], Home], Iterator[dict[str, Any]]]] = {
    "find": _find,
    "describe": _describe,
    "pictures": _pictures,
    "create": _create,
}


def _told(read: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return the content of a capture, or the reason why it cannot be read, after any exception of a library."""
    try:
        return {"found": read()}
    except ProblemError as error:
        return {"problem": {"status": error.status, "code": error.code, "detail": error.detail}}
    except InputError as error:
        return {"refused": [error.where, error.problem, error.cure, error.field]}
    except Exception as error:
        if isinstance(error, OSError) and error.errno in _OF_THE_SERVER:
            return {"errno": error.errno, "error": str(error)}
        with suppress(Exception):  # memory may be too short even for this
            traceback.print_exception(error, limit=-20)
        return {"unreadable": _reason(error), "file": os.fsdecode(_last_opened)}


def _reason(error: Exception) -> str:
    if out_of_memory(error):
        return "needs more memory to read than a capture may use"
    if isinstance(error, RecursionError):
        return "is nested too deeply to be read"
    return f"cannot be read ({type(error).__name__}: {' '.join(str(error).split())[:300]})"


def _note_files(note: int) -> None:
    """Record the file opened last, by Python itself or by the video library."""

    def opened(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes):
            global _last_opened
            path = os.fsencode(arguments[0])
            if not path.startswith((b"/proc/", b"/sys/", b"/dev/")) and not path.endswith((b".py", b".pyc", b".so")):
                _last_opened = path[:NOTE_BYTES]
                os.pwrite(note, _last_opened.ljust(NOTE_BYTES, b"\0"), 0)

    sys.addaudithook(opened)
    av = importlib.import_module("av")
    open_container = av.open

    def open_noted(file: Any, *arguments: Any, **settings: Any) -> Any:
        opened("open", (str(file),))
        return open_container(file, *arguments, **settings)

    av.open = open_noted  # type: ignore[attr-defined]


def _limit(kind: int, most: int) -> None:
    hard = resource.getrlimit(kind)[1]
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _limit_processor(seconds: int) -> None:
    """Limit the next operation to this much processor time; beyond that the system ends the process."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    _limit(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime) + 1 + seconds)


def _send(answers: IO[str], answer: dict[str, Any]) -> None:
    answers.write(json.dumps(answer) + "\n")
    answers.flush()


def _end() -> NoReturn:
    os._exit(_ORPHANED)


if __name__ == "__main__":
    sys.exit(main())
