"""How long finished jobs are kept: the newest so many, for so many days, and as many as fit into so many bytes."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from jobs.home.byte_sizes import bytes_of
from jobs.records.job import Job

__all__ = ["FinishedRun", "Retention", "folder_bytes"]


@dataclass(frozen=True)
class FinishedRun:
    """A finished job, and how many bytes its run folder takes."""

    job: Job
    bytes: int


@dataclass(frozen=True)
class Retention:
    """The retention of finished runs: a kept run meets every condition; by default all are kept."""

    jobs: float = math.inf
    days: float = math.inf
    bytes: float = math.inf

    @classmethod
    def configured(cls, environment: Mapping[str, str] = os.environ) -> Self:
        """Read `HGS_KEEP_JOBS`, `HGS_KEEP_DAYS` and `HGS_KEEP_BYTES`; an empty variable counts as absent.

        Raises:
            InputError: one is no number, or negative.
        """
        given = [environment.get(f"HGS_KEEP_{name}") or "" for name in ("JOBS", "DAYS", "BYTES")]
        return cls(
            bytes_of(given[0], "HGS_KEEP_JOBS") if given[0] else math.inf,
            bytes_of(given[1], "HGS_KEEP_DAYS") if given[1] else math.inf,
            bytes_of(given[2], "HGS_KEEP_BYTES") if given[2] else math.inf,
        )

    def expired(self, runs: Sequence[FinishedRun], now: float) -> list[FinishedRun]:
        """Return the runs to remove among all finished ones; the latest are kept first."""
        expired: list[FinishedRun] = []
        total = 0
        for place, run in enumerate(sorted(runs, key=lambda run: run.job.updated, reverse=True)):
            total += run.bytes
            if place >= self.jobs or now - run.job.updated > self.days * 86400 or total > self.bytes:
                expired.append(run)
        return expired


def folder_bytes(folder: Path) -> int:
    """Return the bytes of the files below a folder; files that vanish meanwhile count nothing."""
    total = 0
    for root, _, names in os.walk(folder):
        for name in names:
            try:
                total += (Path(root) / name).lstat().st_size
            except OSError:
                continue
    return total
