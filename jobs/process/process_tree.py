"""The processes of a stage, in any group or session: their number, and the end of them all.

`RLIMIT_NPROC` would count every process of the user, and does not bind root; a control group of its own needs rights
that a worker in a container does not have. So the worker looks (Linux: in /proc).
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

__all__ = ["THREADS_EACH", "Process", "ProcessTree", "keep_orphans", "too_many"]

THREADS_EACH = 32  # threads on average for each process that is allowed: pools of threads grow with the machine
_LINUX = Path("/proc/self/stat").exists()
_LOOK = 1.0  # seconds between two looks at how many there are
_LOOK_SHARE = 0.02  # largest share of a processor for looking
_ROUNDS = 100  # rounds against processes that multiply while others are killed
_ROUND = 0.02  # seconds for killed ones to end
_TASKS = Path("/proc/self/task")  # the threads of this process
_LISTS_CHILDREN = (_TASKS / str(os.getpid()) / "children").exists()
_SET_CHILD_SUBREAPER = 36  # prctl(2)


@dataclass(frozen=True)
class Process:
    """The system's figures of a process; a zombie counts until its parent has reaped it."""

    pid: int
    parent: int
    group: int
    session: int
    threads: int
    seconds: float  # processor time
    began: int  # ticks after the system's start; tells it from a later process of the same id


class ProcessTree:
    """One process that leads a session, or the calling one, with all that it started and that those did."""

    def __init__(self, root: int) -> None:
        self._root = root
        self._seen: dict[int, int] = {}  # id -> begin; some lose their parent

    def look(self) -> list[Process]:
        """Return all of them; none where the system has no /proc.

        Who lost its parent is found if it has not left the session, was seen before, or the root keeps orphans.
        """
        everything = _processes()
        children: dict[int, list[Process]] = {}
        for process in everything:
            children.setdefault(process.parent, []).append(process)
        new = [process for process in everything if self._is_known(process)]
        found: dict[int, Process] = {}
        while new:
            process = new.pop()
            if process.pid not in found:
                found[process.pid] = process
                new += children.get(process.pid, ())
        self._seen = {process.pid: process.began for process in found.values()}
        return list(found.values())

    def kill(self) -> None:
        """Kill all of them; of the calling process all but itself. Those that multiply meanwhile are found, too."""
        me = os.getpid()
        if self._root == me and _LISTS_CHILDREN:  # all of /proc that a sandbox shows
            _kill_children()
            return
        if self._root != me:  # the root is stopped and not killed at first, so that it keeps the orphans
            _send_group(self._root, signal.SIGSTOP)
        asked: set[int] = {me, self._root}
        for _ in range(_ROUNDS):
            new = [process for process in self.look() if process.pid not in asked]
            if not new:
                break
            pids = {process.pid for process in new}
            for group in {process.group for process in new} & pids:  # a group whose leader is one of them: all at once
                _send_group(group, signal.SIGKILL)
            for pid in pids:
                _send(pid, signal.SIGKILL)
            asked |= pids
        if self._root != me:
            _send_group(self._root, signal.SIGKILL)

    async def until_too_many(self, most: int) -> str:
        """Look now and then; return in one line why they are too many, as soon as they are."""
        while True:
            began = time.perf_counter()
            if reason := too_many(self.look(), most):
                return reason
            await asyncio.sleep(max(_LOOK, (time.perf_counter() - began) / _LOOK_SHARE))

    def _is_known(self, process: Process) -> bool:
        return self._root in (process.pid, process.session) or self._seen.get(process.pid) == process.began


def keep_orphans() -> None:
    """Be the parent of all descendants that lose theirs, so that nothing that this process starts gets lost; Linux."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def too_many(processes: list[Process], most: int) -> str:
    """Return in one line that these are more than `most`, or have too many threads for so many; else ""."""
    threads = sum(process.threads for process in processes)
    if len(processes) > most:
        return f"too many processes: {len(processes)}, limit {most}; raise HGS_STAGE_PROCESSES if they are meant"
    if threads > most * THREADS_EACH:
        limit = f"limit {most * THREADS_EACH}, {THREADS_EACH} for each process of HGS_STAGE_PROCESSES"
        return f"too many threads: {threads}, {limit}; raise that if they are meant"
    return ""


def _kill_children() -> None:
    """Kill the children of this process until it has none: it keeps orphans, so that theirs become its own."""
    for _ in range(_ROUNDS):
        children = [int(pid) for task in _TASKS.iterdir() for pid in _text(task / "children").split()]
        if not children:
            return
        for pid in children:
            _send(pid, signal.SIGKILL)
        for pid in children:
            with contextlib.suppress(ChildProcessError):
                os.waitpid(pid, os.WNOHANG)
        time.sleep(_ROUND)


def _text(file: Path) -> str:
    try:
        return file.read_text()
    except OSError:  # the thread has ended
        return ""


def _processes() -> list[Process]:
    ticks = os.sysconf("SC_CLK_TCK")
    found = []
    for name in os.listdir("/proc") if _LINUX else ():  # noqa: PTH208 - of thousands, and often
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat", "rb") as file:  # noqa: PTH123
                    fields = file.read().rpartition(b")")[2].split()  # the name before may hold anything
            except OSError:
                continue  # it has ended
            parent, group, session = map(int, fields[1:4])
            seconds = (int(fields[11]) + int(fields[12])) / ticks
            found.append(Process(int(name), parent, group, session, int(fields[17]), seconds, int(fields[19])))
    return found


def _send_group(group: int, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, number)


def _send(pid: int, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, number)
