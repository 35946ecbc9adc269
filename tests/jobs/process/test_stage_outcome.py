from __future__ import annotations

import json
import signal

import pytest

from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import (
    Done,
    ExitStatus,
    Failed,
    Killed,
    StageOutcome,
    Waits,
    outcome_of,
    read_outcome,
    record_of,
)


@pytest.mark.parametrize(
    ("status", "reported", "silent", "outcome"),
    [
        (ExitStatus.DONE, Done(), False, Done()),
        (ExitStatus.FAILED, Failed("no loss"), False, Failed("no loss")),
        (ExitStatus.LATER, Waits("full"), False, Waits("full")),
        (
            -signal.SIGKILL,
            Done(),
            True,
            Killed("train: hung: nothing was heard of it for too long, and it was killed"),
        ),
        (-signal.SIGSEGV, Done(), False, Killed("train: ended by SIGSEGV")),
        (ExitStatus.FAILED, Done(), False, Failed("train: exit status 1; see stage.log in the run folder")),
        (ExitStatus.STOPPED, Done(), False, Killed("train: exit status 75; see stage.log in the run folder")),
    ],
)
def test_outcomes(status: int, reported: StageOutcome, silent: bool, outcome: StageOutcome) -> None:
    assert outcome_of("train", status, reported, silent=silent, killed_before=None) == outcome


@pytest.mark.parametrize(
    ("outcome", "record"),
    [
        (Done(), {}),
        (Failed("no loss"), {"error": "no loss"}),
        (Waits("full"), {"waiting": "full"}),
        (Waits("full", Cause.DISK), {"waiting": "full", "cause": "disk"}),
        (Killed("ended by SIGKILL"), {"killed": "ended by SIGKILL"}),
    ],
)
def test_an_outcome_survives_its_record(outcome: StageOutcome, record: dict[str, str]) -> None:
    assert record_of(outcome) == record
    assert read_outcome(json.loads(json.dumps(record))) == outcome
