"""Which jobs a list shows: those with labels, of a capture, of some days, or with words in their titles."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sqlalchemy as sa

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable
from jobs.records.job_schema import job_labels, job_rows

__all__ = ["MAX_LABELS", "MAX_LABEL_LENGTH", "JobFilter", "checked_labels"]

MAX_LABELS = 20
MAX_LABEL_LENGTH = 64  # characters


@dataclass(frozen=True)
class JobFilter:
    """Only jobs that meet every condition that is given; none is, by default."""

    labels: tuple[str, ...] = ()  # all of them
    capture: str = ""  # the absolute path
    words: str = ""  # a part of the id or the title, in upper or lower case
    since: float = 0.0  # submitted at this time or later, seconds since the epoch
    until: float = 0.0  # submitted before; 0 for no end

    def conditions(self) -> list[sa.ColumnElement[bool]]:
        """Return the conditions on rows of `hgs_job`."""
        conditions: list[sa.ColumnElement[bool]] = [
            job_rows.c.id.in_(sa.select(job_labels.c.job_id).where(job_labels.c.label == label))
            for label in self.labels
        ]
        if self.capture:
            conditions.append(job_rows.c.capture == self.capture)
        if self.words:
            found = [column.icontains(self.words, autoescape=True) for column in (job_rows.c.title, job_rows.c.id)]
            conditions.append(sa.or_(*found))
        if self.since:
            conditions.append(job_rows.c.created >= self.since)
        if self.until:
            conditions.append(job_rows.c.created < self.until)
        return conditions


def checked_labels(labels: Iterable[str]) -> tuple[str, ...]:
    """Return labels without repetitions, in order.

    Raises:
        InputError: there are more than 20, or one is empty, longer than 64 characters, or holds spaces, commas or
            control characters.
    """
    found = tuple(dict.fromkeys(labels))
    if len(found) > MAX_LABELS:
        raise InputError.of_field("labels", f"{len(found)} are too many", f"give at most {MAX_LABELS}")
    for label in found:
        if not 0 < len(label) <= MAX_LABEL_LENGTH:
            raise InputError.of_field(
                "labels", f"{label[:80]!a} has {len(label)} characters", f"use 1 to {MAX_LABEL_LENGTH}"
            )
        if not is_storable(label) or not label.isprintable() or any(one.isspace() or one == "," for one in label):
            raise InputError.of_field(
                "labels", f"{label!a} holds a space, a comma or a control character", "use - instead"
            )
    return found
