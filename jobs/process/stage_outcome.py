"""The outcome of a stage, in one line: its own report, or else its exit status and the system's."""

from __future__ import annotations

import signal
from dataclasses import dataclass

from jobs.process.memory_limit import CURE, system_kills

__all__ = ["StageOutcome", "outcome_of"]


@dataclass(frozen=True)
class StageOutcome:
    """How a stage ended: `error` and `waiting` are one line each, and empty on success."""

    error: str = ""
    waiting: str = ""  # the fault passes: the stage shall be run again later
    killed: bool = False  # a signal ended it and not its own code
    cause: str = ""  # the `Cause` of `waiting`, if this machine found one


def outcome_of(stage: str, status: int, said: StageOutcome, *, silent: bool, killed_before: int | None) -> StageOutcome:
    """Return the outcome of a stage from the exit status of its process.

    `said` is what it told of its failure, if anything; `silent`: it was killed for saying nothing; `killed_before` is
    `system_kills` of when it began.
    """
    if status == 0:
        return StageOutcome()
    if said.error or said.waiting:
        return said
    if silent:
        return StageOutcome(f"{stage}: hung: nothing was heard of it for too long, and it was killed", killed=True)
    if status < 0:
        name = signal.Signals(-status).name
        if -status != signal.SIGKILL:
            return StageOutcome(f"{stage}: ended by {name}", killed=True)
        killed = system_kills()
        if killed is None or killed_before is None:
            hint = "(out of memory?)"
        elif killed > killed_before:
            return StageOutcome(f"{stage}: out of memory: the system killed it; {CURE}", killed=True)
        else:
            hint = "from outside; the system did not run out of memory"
        return StageOutcome(f"{stage}: ended by {name} {hint}", killed=True)
    return StageOutcome(f"{stage}: exit status {status}; see stage.log in the run folder", killed=status == 75)
