from __future__ import annotations

import math
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.records.job import Job
from jobs.runs.retention import FinishedRun, Retention, folder_bytes

DAY = 86400.0
NOW = 100 * DAY
RUNS = [FinishedRun(Job(name, "", "", {}, updated=NOW - days * DAY), 100) for name, days in zip("bca", (2, 3, 1))]  # noqa: B905


@pytest.mark.parametrize(
    ("retention", "expired"),
    [
        (Retention(), ""),
        (Retention(jobs=2), "c"),
        (Retention(jobs=0), "abc"),
        (Retention(days=2.5), "c"),
        (Retention(bytes=250), "c"),
        (Retention(bytes=99), "abc"),
        (Retention(jobs=2, days=1.5), "bc"),
    ],
)
def test_what_ended_first_goes_first(retention: Retention, expired: str) -> None:
    assert [run.job.id for run in retention.expired(RUNS, NOW)] == list(expired)


def test_the_settings_are_read() -> None:
    assert Retention.configured({}) == Retention(math.inf, math.inf, math.inf)
    given = {"HGS_KEEP_JOBS": "20", "HGS_KEEP_DAYS": "1.5", "HGS_KEEP_BYTES": "500G"}
    assert Retention.configured(given) == Retention(20, 1.5, 5e11)
    with pytest.raises(InputError, match="HGS_KEEP_DAYS"):
        Retention.configured({"HGS_KEEP_DAYS": "a week"})


def test_the_bytes_of_a_folder_are_those_of_its_files(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "one").write_bytes(b"x" * 10)
    (tmp_path / "a" / "b" / "two").write_bytes(b"x" * 5)
    (tmp_path / "a" / "link").symlink_to("nowhere")
    assert folder_bytes(tmp_path / "a") == 15 + len("nowhere")
    assert folder_bytes(tmp_path / "none") == 0
