from __future__ import annotations

import time
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from jobs.records.job import Job, JobState
from server.cli.job_words import duration, job_details, job_table, no_worker, seconds_of, since, worker_table
from server.job_views.job_description import describe_job


def job(**fields: Any) -> dict[str, Any]:
    plain = Job("studio-1", "Studio", "/captures/studio", {}, created=1000.0, updated=1000.0)
    return describe_job(Job(**{**plain.__dict__, **fields}))


@pytest.mark.parametrize(
    ("text", "seconds"), [("90", 90), ("90s", 90), ("15m", 900), ("12h", 43200), ("3d", 259200), ("1.5h", 5400)]
)
def test_durations_are_read(text: str, seconds: float) -> None:
    assert seconds_of(text, "--since") == seconds


@pytest.mark.parametrize("text", ["", "h", "-1h", "1w", "1 h", "soon"])
def test_what_is_no_duration_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--since"):
        seconds_of(text, "--since")


def test_a_moment_is_a_date_or_so_long_ago() -> None:
    assert since("2026-11-22", "--since") == 1795305600.0
    assert since("2026-11-22T01:00:00+01:00", "--since") == 1795305600.0
    assert since("1h", "--since") == pytest.approx(time.time() - 3600, abs=60)


@pytest.mark.parametrize(
    ("seconds", "text"), [(-5, "0 s"), (59, "59 s"), (150, "2 min"), (3700, "1 h 1 min"), (90000, "1 d 1 h")]
)
def test_durations_are_shown_in_two_units(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_a_table_of_jobs() -> None:
    running = job(state=JobState.RUNNING, stage="train", done=3, total=9, ends=1700.0, labels=("a", "b"))
    head, line, other = job_table([running, job(priority=-5)], now=1600.0).splitlines()
    assert head.split() == ["JOB", "STATE", "STAGE", "LEFT", "PRIO", "AGE", "LABELS", "TITLE"]
    assert line.split() == ["studio-1", "running", "train", "3/9", "1", "min", "0", "10", "min", "a,b", "Studio"]
    assert other.split() == ["studio-1", "queued", "-", "-", "-5", "10", "min", "-", "Studio"]


def test_what_there_is_to_say_of_a_job() -> None:
    text = job_details(job(state=JobState.FAILED, error="out of memory", time_limit=7200.0), now=1060.0)
    assert "error       out of memory\n" in text
    assert "time limit  2 h 0 min\n" in text
    assert text.endswith("last word   1 min ago")
    assert "waits for" not in text


@pytest.mark.parametrize(("audio", "shown"), [("", []), ("auto", []), ("camera:cam01", ["sound       camera:cam01"])])
def test_the_sound_of_a_job_is_shown_if_one_was_chosen(audio: str, shown: list[str]) -> None:
    lines = job_details(job(audio=audio), now=1600.0).splitlines()
    assert [line for line in lines if line.startswith("sound")] == shown


def test_a_table_of_workers() -> None:
    worker = {"id": "a-1", "host": "a", "device": None, "job": None, "idle_because": "no home", "started": 0.0}
    assert worker_table([worker], now=60.0).splitlines()[1].split() == ["a-1", "a", "-", "-", "1", "min", "no", "home"]


def test_queued_jobs_that_nobody_takes_are_called_so() -> None:
    queued, done = {"state": "queued"}, {"state": "succeeded"}
    line = "queued; no worker is running: start one with hgs worker, or hgs serve"
    assert no_worker([done, queued], []) == line
    assert no_worker([queued], [], "http://host:8000").startswith("queued; no worker is running at http://host:8000: ")
    assert no_worker([queued], [object()]) == ""
    assert no_worker([done], []) == ""
    assert no_worker([], []) == ""
