from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from jobs.records.job import Job, JobState, Place
from jobs.records.job_filter import JobFilter
from server.http.problems import ProblemError
from server.job_views.job_query import JobQuery, cursor


def test_a_query_without_parameters_is_the_first_hundred() -> None:
    assert JobQuery.read([]) == JobQuery(limit=100, state=None, after=None)


def test_limit_and_state_are_read() -> None:
    assert JobQuery.read([("limit", "7"), ("state", "running")]) == JobQuery(limit=7, state=JobState.RUNNING)
    assert JobQuery.read([("limit", "1000")]).limit == 1000


@given(created=st.floats(1.0, 1e11), state=st.sampled_from(JobState))
def test_the_cursor_of_a_job_is_read_as_its_place(created: float, state: JobState) -> None:
    job = Job("studio-1a2b", "Studio", "/captures/studio", {}, created=created, updated=created, state=state)
    assert JobQuery.read([("after", cursor(job))]).after == Place.of(job)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("limit", "0"),
        ("limit", "1001"),
        ("limit", "1e2"),
        ("limit", ""),
        ("limit", "99999"),
        ("state", "done"),
        ("state", "Running"),
        ("after", "zzz"),
        ("after", "0/1e999/a"),
        ("after", "0/1.2.3/a"),
        ("after", "\0"),
        ("after", "3/1.0/a"),
        ("before", "a"),
        ("page", "2"),
        ("label", "two words"),
        ("capture", ""),
        ("find", "a\0"),
        ("since", "yesterday"),
        ("until", "-1"),
        ("until", "1e5"),
    ],
)
def test_what_is_not_understood_is_refused_by_name(name: str, value: str) -> None:
    with pytest.raises(ProblemError, match=name) as caught:
        JobQuery.read([(name, value)])
    assert (caught.value.status, caught.value.code, caught.value.field) == (422, "query-invalid", name)


def test_what_is_wanted_is_read() -> None:
    given = [("label", "a"), ("capture", "/c"), ("label", "b"), ("find", "x y"), ("since", "10"), ("until", "20.5")]
    assert JobQuery.read(given).wanted == JobFilter(("a", "b"), "/c", "x y", 10.0, 20.5)


def test_a_parameter_is_given_once() -> None:
    with pytest.raises(ProblemError, match="limit: given twice"):
        JobQuery.read([("limit", "1"), ("limit", "2")])
