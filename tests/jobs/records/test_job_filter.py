from __future__ import annotations

import pytest
import sqlalchemy as sa

from hgs_core.base.errors import InputError
from jobs.records.job import Job, JobState
from jobs.records.job_filter import JobFilter, checked_labels
from jobs.records.job_schema import job_rows
from jobs.records.job_table import JobTable


@pytest.fixture
def table(engine: sa.Engine) -> JobTable:
    """Jobs a, b and c, submitted at 100 s, 200 s and 300 s."""
    table = JobTable(engine)
    with engine.begin() as connection:
        for job in (
            Job("a", "Dance 100%", "/captures/dance", {}, labels=("night", "acme")),
            Job("b", "Dance 1000", "/captures/dance", {}, labels=("night",)),
            Job("c", "Ball_7", "/captures/ball", {}),
        ):
            table.insert(connection, job)
        for created, name in ((100.0, "a"), (200.0, "b"), (300.0, "c")):
            connection.execute(sa.update(job_rows).where(job_rows.c.id == name).values(created=created))
    return table


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        (JobFilter(), "cba"),
        (JobFilter(labels=("night",)), "ba"),
        (JobFilter(labels=("night", "acme")), "a"),
        (JobFilter(labels=("nigh",)), ""),
        (JobFilter(capture="/captures/dance"), "ba"),
        (JobFilter(capture="/captures"), ""),
        (JobFilter(words="dance"), "ba"),
        (JobFilter(words="100%"), "a"),  # and not as a pattern
        (JobFilter(words="l_7"), "c"),
        (JobFilter(words="e_1"), ""),
        (JobFilter(since=200.0), "cb"),
        (JobFilter(until=200.0), "a"),
        (JobFilter(since=150.0, until=250.0, labels=("night",)), "b"),
    ],
)
def test_jobs_that_meet_every_condition_are_listed(table: JobTable, wanted: JobFilter, found: str) -> None:
    assert [job.id for job in table.page(10, wanted=wanted)] == list(found)


def test_conditions_and_states_and_labels_go_together(table: JobTable) -> None:
    table.start("a", 1)
    (job,) = table.page(10, JobState.RUNNING, wanted=JobFilter(labels=("night",)))
    assert (job.id, job.labels) == ("a", ("night", "acme"))


def test_labels_are_kept_in_order_and_once() -> None:
    assert checked_labels(["b", "a", "b"]) == ("b", "a")


@pytest.mark.parametrize("label", ["", "x" * 65, "two words", "a,b", "a\0", "\ud800", "a\n", "\x1b[2J"])
def test_a_label_that_no_command_line_could_name_is_refused(label: str) -> None:
    with pytest.raises(InputError, match="labels"):
        checked_labels([label])


def test_there_are_at_most_twenty_labels() -> None:
    assert len(checked_labels(map(str, range(20)))) == 20
    with pytest.raises(InputError, match="21 are too many"):
        checked_labels(map(str, range(21)))
