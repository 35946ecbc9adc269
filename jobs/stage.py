"""One stage of one run, in a process of its own: `python -m jobs.stage STAGE RUN`.

A process of its own frees its memory (also on the GPU) when it ends and can be killed. It speaks with the worker that
started it by plain means:

- stdout: JSON lines, `{"stage", "done", "total", "figures"}` at most twice a second; before it fails `{"error"}`, or
  `{"waiting"}` if the fault is one that passes: of the store, a disk or a mount (see stage_outcome.py);
- stderr: when it began and ended, whatever the libraries print, and the traceback of a failure;
- `{"publish"}` on stdout asks the worker to publish what a training by segments has made so far: the stage may lack the
  secrets for that. The answer comes on stdin, in the same form, `{}` if all went well;
- stdin: when it closes the worker is gone, and the process ends at once;
- SIGTERM, SIGINT: the stage saves what it can resume from and stops.

Exit status: 0 done, 1 failed, 2 bad input, 69 try again later, 70 the worker is gone, 75 stopped.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import importlib
import json
import logging
import os
import queue
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType, ModuleType
from typing import IO, Any, NoReturn

from hgs_core.base.errors import InputError
from hgs_core.base.heap import share_heap
from hgs_core.base.progress import Progress, ProgressCallback, StageStopped, stop_if_interruptible
from hgs_core.runs.run_folder import RunFolder
from jobs.home.home import Home
from jobs.home.passing_faults import passing_fault
from jobs.home.stage_settings import HELP, SHOW, STAGES
from jobs.process.file_limits import met_file_limit
from jobs.process.limited import limit_stage
from jobs.process.memory_limit import out_of_memory
from jobs.process.parent_process import when_parent_is_gone
from jobs.process.process_tree import ProcessTree
from jobs.process.stage_environment import keep_secrets
from jobs.process.stage_outcome import Done, ExitStatus, Failed, Killed, Waits, read_outcome, record_of
from jobs.process.stage_sandbox import enter_stage_sandbox
from jobs.runs.shared_segments import Exchange, help_with_segment, make_segments

__all__ = ["main"]

REPORT_INTERVAL = 0.5  # seconds between two progress lines
LOCK_WAIT = 60.0  # seconds to wait for an earlier process of the same run to end

_SENDING = threading.Lock()

log = logging.getLogger("hgs.stage")


def main(arguments: list[str] | None = None) -> int:
    """Run the stage that the command line names and return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m jobs.stage", description="Run one stage of one run.")
    parser.add_argument("stage", choices=(*STAGES, HELP, SHOW))
    parser.add_argument("run", type=Path)
    options = parser.parse_args(arguments)
    if arguments is None:  # a process of its own
        share_heap()
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s")

    stop = threading.Event()

    def ask_to_stop(number: int, frame: FrameType | None) -> None:
        stop.set()
        stop_if_interruptible()

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, ask_to_stop)
    answers: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    report = _claim_stdout()
    home = Home.from_environment()
    limit_stage(home, options.stage)
    try:
        if arguments is None:  # there is no other thread yet
            enter_stage_sandbox(home, options.stage, options.run)
        when_parent_is_gone(_end, answers.put)
        with contextlib.ExitStack() as held:
            try:
                if options.stage not in (HELP, SHOW):  # these run beside the one that has the lock
                    held.enter_context(RunFolder(options.run).exclusive(LOCK_WAIT, lambda: _lost(report)))
            except InputError as error:  # an earlier process: on another machine, or one that cannot be killed
                _send(report, record_of(Waits(str(error))))
                return ExitStatus.LATER
            began = time.monotonic()
            log.info("%s begins", options.stage)
            publish = functools.partial(_ask_to_publish, report, answers)
            _run(options.stage, options.run, home, _throttled(report, stop), publish, lambda: _lost(report))
            log.info("%s is complete after %.1f s", options.stage, time.monotonic() - began)
    except StageStopped:
        log.info("%s was asked to stop, and has saved what it needs to go on", options.stage)
        return ExitStatus.STOPPED
    except Exception as error:
        return _explain(error, report)
    finally:
        ProcessTree(os.getpid()).kill()  # it alone knows all of its descendants
    return ExitStatus.DONE


def _end() -> NoReturn:
    """End without the worker, and leave no process behind that nobody would look after."""
    with contextlib.suppress(ChildProcessError):  # no children: nothing to look for
        os.waitpid(-1, os.WNOHANG)
        ProcessTree(os.getpid()).kill()
    os._exit(ExitStatus.ORPHANED)


def _lost(report: IO[str]) -> NoReturn:
    _send(report, record_of(Waits("another process has taken this run over")))
    os._exit(ExitStatus.LATER)


def _explain(error: Exception, report: IO[str]) -> ExitStatus:
    """Report the reason of a failure to the worker, in one line, and return the exit status."""
    outcome, status = _verdict(error)
    _send(report, record_of(outcome))
    if status != ExitStatus.BAD_INPUT and not isinstance(error, _NotPublishedError):  # the worker logged that already
        with contextlib.suppress(OSError):  # the log may lie on the disk that is full
            traceback.print_exception(error)
    return status


def _verdict(error: Exception) -> tuple[Failed | Waits, ExitStatus]:
    if isinstance(error, _NotPublishedError):
        return error.outcome, ExitStatus.LATER if isinstance(error.outcome, Waits) else ExitStatus.FAILED
    if limit := met_file_limit(error):  # too many open files: of a worker that passes, but of a stage it would recur
        return Failed(limit), ExitStatus.FAILED
    if (fault := passing_fault(error)) is not None:
        return Waits(fault.reason), ExitStatus.LATER
    if isinstance(error, InputError):
        return Failed(str(error)), ExitStatus.BAD_INPUT
    if too_little := out_of_memory(error):
        return Failed(too_little), ExitStatus.FAILED
    summary = " ".join(str(error).split()) or "no message"
    return Failed(f"{type(error).__name__}: {summary}"), ExitStatus.FAILED


def _run(
    stage: str,
    run: Path,
    home: Home,
    progress: ProgressCallback,
    publish: Callable[[], None],
    on_lost: Callable[[], object],
) -> None:
    if stage in ("publish", SHOW):
        from jobs.artifacts.artifact_store import open_store

        keep_secrets()
        open_store(home).put_scene(run / "scene", run.name, progress)
        return
    pipeline = importlib.import_module(home.pipeline)
    if stage == STAGES[0]:
        _state_need(pipeline, run, home)
    exchange: Exchange | None = None
    with contextlib.ExitStack() as held:
        if home.runs_in_store and stage == HELP:
            from jobs.runs.stored_segments import fetch_for_help

            held.enter_context(fetch_for_help(home, run))
        segments = getattr(pipeline, "segments_of", lambda run: None)(run) if stage in ("train", HELP) else None
        if home.runs_in_store and segments is not None:
            from jobs.runs.stored_segments import StoredSegments

            exchange = StoredSegments.of(home, run, segments, on_lost)
        if stage == HELP:
            if segments is not None:
                help_with_segment(segments, run, progress, publish, exchange)
        elif segments is not None:
            make_segments(segments, run, progress, publish, exchange)
        else:
            getattr(pipeline, stage)(run, progress)


def _state_need(pipeline: ModuleType, run: Path, home: Home) -> None:
    """Log the need of a job before any of its work.

    Raises:
        InputError: this machine, or the memory that a stage of the job is given, is less than that.
    """
    require_room = getattr(pipeline, "require_room", None)
    if require_room is not None:
        memory = home.limits.memory
        limits = {} if memory is None else {name: memory.of(name) for name in STAGES}
        need = require_room(run, limits)
        if need is not None:
            log.info("the training %s", need.sentence())


class _NotPublishedError(Exception):
    """The worker could not publish; `outcome` is its answer."""

    def __init__(self, outcome: Failed | Waits) -> None:
        super().__init__(outcome)
        self.outcome = outcome


def _ask_to_publish(report: IO[str], answers: queue.SimpleQueue[bytes]) -> None:
    """Have the worker publish the scene as far as it is made. One thread at a time may ask."""
    _send(report, {"publish": True})
    match read_outcome(json.loads(answers.get())):
        case Failed() | Waits() as outcome:
            raise _NotPublishedError(outcome)
        case Killed(reason):  # the stage is not to blame
            raise _NotPublishedError(Waits(reason))
        case Done():
            return


def _claim_stdout() -> IO[str]:
    """Return the real stdout for our lines, and send all other prints to stderr."""
    ours = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return ours


def _throttled(report: IO[str], stop: threading.Event) -> ProgressCallback:
    """Return a callback that stops the stage on demand and passes on the first, the last and timely reports."""
    next_report = 0.0

    def progress(update: Progress) -> None:
        nonlocal next_report
        if stop.is_set():
            raise StageStopped
        now = time.monotonic()
        if now < next_report and update.done < update.total:
            return
        next_report = now + REPORT_INTERVAL
        figures = {name: float(value) for name, value in update.figures.items()}
        _send(report, {"stage": update.stage, "done": update.done, "total": update.total, "figures": figures})

    return progress


def _send(report: IO[str], message: dict[str, Any]) -> None:
    with _SENDING:  # a thread may publish segments of others meanwhile
        report.write(json.dumps(message) + "\n")
        report.flush()


if __name__ == "__main__":
    sys.exit(main())
