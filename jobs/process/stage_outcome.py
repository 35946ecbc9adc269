"""The outcome of a stage: its own report, or else its exit status and the system's."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import assert_never

from jobs.home.passing_faults import Cause
from jobs.process.memory_limit import CURE, system_kills

__all__ = ["Done", "ExitStatus", "Failed", "Killed", "StageOutcome", "Waits", "outcome_of", "read_outcome", "record_of"]


class ExitStatus(IntEnum):
    """The exit status of a stage's process; from 69 on as in sysexits.h."""

    DONE = 0
    FAILED = 1
    BAD_INPUT = 2
    LATER = 69
    ORPHANED = 70
    STOPPED = 75


@dataclass(frozen=True)
class Done:
    """Success."""


@dataclass(frozen=True)
class Failed:
    """A failure that would occur again, in one line."""

    error: str


@dataclass(frozen=True)
class Waits:
    """A fault that passes, in one line: the stage is run again later."""

    reason: str
    cause: Cause | None = None  # None: unknown


@dataclass(frozen=True)
class Killed:
    """An end from outside the stage's own code, in one line: by a signal, for its silence, or on request."""

    error: str


StageOutcome = Done | Failed | Waits | Killed


def record_of(outcome: StageOutcome) -> dict[str, str]:
    """Return the outcome as plain JSON: the form of workflows' records and of a stage's words with its worker."""
    match outcome:
        case Done():
            return {}
        case Failed(error):
            return {"error": error}
        case Waits(reason, cause):
            return {"waiting": reason} if cause is None else {"waiting": reason, "cause": cause.value}
        case Killed(error):
            return {"killed": error}
        case _:
            assert_never(outcome)


def read_outcome(record: Mapping[str, str]) -> StageOutcome:
    """Return the outcome of a record that `record_of` made."""
    match record:
        case {"error": error}:
            return Failed(error)
        case {"waiting": reason, "cause": cause}:
            return Waits(reason, Cause(cause))
        case {"waiting": reason}:
            return Waits(reason)
        case {"killed": error}:
            return Killed(error)
    return Done()


def outcome_of(
    stage: str, status: int, reported: StageOutcome, *, silent: bool, killed_before: int | None
) -> StageOutcome:
    """Return the outcome of a stage from the exit status of its process.

    `reported` is its own report of a failure, `Done` if it made none; `silent`: it was killed for its silence;
    `killed_before` is `system_kills` at its start.
    """
    if status == ExitStatus.DONE:
        return Done()
    if not isinstance(reported, Done):
        return reported
    if silent:
        return Killed(f"{stage}: hung: nothing was heard of it for too long, and it was killed")
    if status < 0:
        name = signal.Signals(-status).name
        if -status != signal.SIGKILL:
            return Killed(f"{stage}: ended by {name}")
        killed = system_kills()
        if killed is None or killed_before is None:
            hint = "(out of memory?)"
        elif killed > killed_before:
            return Killed(f"{stage}: out of memory: the system killed it; {CURE}")
        else:
            hint = "from outside; the system did not run out of memory"
        return Killed(f"{stage}: ended by {name} {hint}")
    error = f"{stage}: exit status {status}; see stage.log in the run folder"
    return Killed(error) if status == ExitStatus.STOPPED else Failed(error)
