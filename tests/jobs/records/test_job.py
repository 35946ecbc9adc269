from __future__ import annotations

import json

import pytest

from jobs.records.job import ACTIVE, Job, JobState, Place

JOB = Job("j1", "Dance", "/captures/dance", {"seed": 1})


@pytest.mark.parametrize(
    ("state", "turn"),
    [("running", 0), ("queued", 1), ("waiting", 1), ("succeeded", 2), ("failed", 2), ("cancelled", 2)],
)
def test_a_job_s_turn_in_the_list_follows_from_its_state(state: str, turn: int) -> None:
    job = Job(JOB.id, JOB.title, JOB.capture, JOB.config, JobState(state), created=5.0)
    assert Place.of(job) == Place(turn, 5.0, "j1")
    assert JobState(state).finished is (turn == 2)
    assert (JobState(state) in ACTIVE) is (turn < 2)


def test_a_job_becomes_plain_json() -> None:
    told = json.loads(json.dumps(JOB.to_json()))
    assert (told["id"], told["state"], told["config"]) == ("j1", "queued", {"seed": 1})
