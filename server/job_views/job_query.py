"""Query parameters of `GET /v1/jobs`: filters, page size and cursor."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NoReturn, Self

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable
from jobs.records.job import Job, JobState, Place
from jobs.records.job_filter import JobFilter, checked_labels
from server.http.problems import ProblemError

__all__ = ["JobQuery", "cursor"]

_LIMIT = 100  # jobs per page by default
_MOST = 1000
_KNOWN = ("after", "capture", "find", "label", "limit", "since", "state", "until")
_LONGEST_TEXT = 4096  # characters; the longest path
_SECONDS = re.compile(r"[0-9]{1,12}(\.[0-9]{1,20})?")
_CURSOR = re.compile(r"([012])/([0-9]{1,12}\.[0-9]{1,20})/([a-z0-9_-]{1,64})")


@dataclass(frozen=True)
class JobQuery:
    """A page of the list of jobs."""

    limit: int = _LIMIT
    state: JobState | None = None
    after: Place | None = None
    wanted: JobFilter = field(default_factory=JobFilter)

    @classmethod
    def read(cls, parameters: Sequence[tuple[str, str]]) -> Self:
        """Read the query's parameters.

        Raises:
            ProblemError: 422, an unknown or repeated parameter, or a bad value.
        """
        given: dict[str, str] = {}
        labels: list[str] = []
        for name, value in parameters:
            if name not in _KNOWN:
                _refuse(name, f"unknown parameter {name[:40]!a}; known are {', '.join(_KNOWN)}")
            if name in given and name != "label":
                _refuse(name, f"{name}: given twice")
            given[name] = value
            labels += [value] if name == "label" else []
        limit, state = given.get("limit", str(_LIMIT)), given.get("state")
        if not re.fullmatch("[1-9][0-9]{0,3}", limit) or int(limit) > _MOST:
            _refuse("limit", f"limit: {limit[:40]!a} is not a number of jobs; give 1 to {_MOST}")
        if state is not None and state not in list(JobState):
            _refuse("state", f"state: {state[:40]!a} is not a job state; use one of {', '.join(JobState)}")
        wanted = JobFilter(
            _labels(labels), _text(given, "capture"), _text(given, "find"), _date(given, "since"), _date(given, "until")
        )
        return cls(int(limit), None if state is None else JobState(state), _place(given.get("after")), wanted)


def cursor(job: Job) -> str:
    """Return the `after` parameter of the page that follows this job."""
    place = Place.of(job)
    return f"{place.turn}/{place.created!r}/{place.job_id}"


def _place(text: str | None) -> Place | None:
    if text is None:
        return None
    parts = _CURSOR.fullmatch(text)
    if parts is None:
        _refuse("after", f"after: {text[:80]!a} is not the `next` value of a page of jobs")
    return Place(int(parts[1]), float(parts[2]), parts[3])


def _labels(labels: Sequence[str]) -> tuple[str, ...]:
    try:
        return checked_labels(labels)
    except InputError as error:
        _refuse("label", str(error))


def _text(given: dict[str, str], name: str) -> str:
    text = given.get(name, "")
    if name in given and not (0 < len(text) <= _LONGEST_TEXT and is_storable(text)):
        _refuse(name, f"{name}: give text of 1 to {_LONGEST_TEXT} characters")
    return text


def _date(given: dict[str, str], name: str) -> float:
    text = given.get(name, "0")
    if not _SECONDS.fullmatch(text):
        _refuse(name, f"{name}: {text[:40]!a} is not a date; give seconds since 1970-01-01 UTC")
    return float(text)


def _refuse(name: str, detail: str) -> NoReturn:
    raise ProblemError(422, "query-invalid", detail, field=name)
