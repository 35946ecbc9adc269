from __future__ import annotations

import signal

import pytest

from jobs.process.stage_outcome import StageOutcome, outcome_of


@pytest.mark.parametrize(
    ("status", "said", "silent", "outcome"),
    [
        (0, StageOutcome(), False, StageOutcome()),
        (1, StageOutcome("no loss"), False, StageOutcome("no loss")),
        (69, StageOutcome(waiting="full"), False, StageOutcome(waiting="full")),
        (
            -signal.SIGKILL,
            StageOutcome(),
            True,
            StageOutcome("train: hung: nothing was heard of it for too long, and it was killed", killed=True),
        ),
        (-signal.SIGSEGV, StageOutcome(), False, StageOutcome("train: ended by SIGSEGV", killed=True)),
        (1, StageOutcome(), False, StageOutcome("train: exit status 1; see stage.log in the run folder")),
        (
            75,
            StageOutcome(),
            False,
            StageOutcome("train: exit status 75; see stage.log in the run folder", killed=True),
        ),
    ],
)
def test_outcomes(status: int, said: StageOutcome, silent: bool, outcome: StageOutcome) -> None:
    assert outcome_of("train", status, said, silent=silent, killed_before=None) == outcome
