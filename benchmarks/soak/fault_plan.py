"""The plan of a soak's faults: kinds and moments drawn from a seed."""

from __future__ import annotations

import random
from dataclasses import dataclass
from enum import StrEnum

__all__ = ["Fault", "PlannedFault", "plan_faults"]

FIRST = 20.0  # seconds before the first fault: enough for a capture and jobs to be there
GAP = 5.0  # mean seconds between two faults
CALM = 0.4  # share of the soak after which API and workers live on, so that their curves have a slope


class Fault(StrEnum):
    """The kinds of faults."""

    KILL_STAGE = "kill a stage"
    KILL_WORKER = "kill a worker"
    KILL_API = "kill the API"
    KILL_COLLECTOR = "kill the collector of chunks"
    STOP_WORKER = "stop a worker"
    STOP_API = "stop the API"
    PAUSE_WORKER = "freeze a worker"
    RESTART_DATABASE = "restart Postgres"
    DROP_DATABASE = "drop links to Postgres"
    STORE_REFUSES = "S3 refuses"
    STORE_HANGS = "S3 hangs"
    STORE_LATE = "S3 answers late"
    DROP_STORE = "drop links to S3"
    DROP_CLIENTS = "drop links of clients"
    FULL_DISK = "fill the disk"
    STEP_CLOCK = "step a clock"
    ROTATE_KEYS = "rotate keys"


_ENDING = (Fault.KILL_WORKER, Fault.KILL_API, Fault.STOP_WORKER, Fault.STOP_API)
_WEIGHTS = dict.fromkeys(Fault, 1.0) | {Fault.KILL_STAGE: 3.0, Fault.KILL_WORKER: 2.0, Fault.KILL_API: 2.0}
_SECONDS = {
    Fault.PAUSE_WORKER: (5.0, 40.0),
    Fault.RESTART_DATABASE: (0.5, 8.0),
    Fault.STORE_REFUSES: (2.0, 12.0),
    Fault.STORE_HANGS: (2.0, 12.0),
    Fault.STORE_LATE: (5.0, 15.0),
    Fault.FULL_DISK: (3.0, 12.0),
    Fault.STEP_CLOCK: (5.0, 20.0),
}


@dataclass(frozen=True)
class PlannedFault:
    """A fault: its moment, its length, and a number in [0, 1) that chooses its victim."""

    at: float  # seconds since the start of the soak
    kind: Fault
    seconds: float
    choice: float


def plan_faults(seed: int, seconds: float) -> list[PlannedFault]:
    """Return the faults of a soak of so many seconds, in order; the same for the same seed."""
    dice = random.Random(seed)
    plan: list[PlannedFault] = []
    at = FIRST
    while (at := at + dice.expovariate(1 / GAP)) < seconds:
        (kind,) = dice.choices(list(_WEIGHTS), list(_WEIGHTS.values()))
        lasts, choice = dice.uniform(*_SECONDS.get(kind, (0.0, 0.0))), dice.random()
        if at < CALM * seconds or kind not in _ENDING:
            plan.append(PlannedFault(at, kind, min(lasts, seconds - at), choice))
    return plan
