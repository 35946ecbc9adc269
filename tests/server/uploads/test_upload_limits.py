from __future__ import annotations

from collections.abc import Callable

import pytest

from hgs_core.base.errors import InputError
from server.http.problems import ProblemError
from server.uploads.upload_limits import UploadLimits, bytes_for_people


def test_what_is_given_counts_before_the_variable_and_the_rest_stays() -> None:
    limits = UploadLimits.configured("quota=2T, file=1.5g,files=7,hours=0.5", {"HGS_UPLOADS": "files=9"})
    assert limits == UploadLimits(quota=2 * 1000**4, file=1_500_000_000, files=7, hours=0.5)
    assert UploadLimits.configured(environment={"HGS_UPLOADS": "free=10MB"}).free == 10_000_000
    assert UploadLimits.configured(environment={}) == UploadLimits()


@pytest.mark.parametrize(
    "text", ["size=1", "quota", "quota=", "quota=-1", "quota=inf", "quota=1,quota=2", "files=0", "hours=0"]
)
def test_what_is_no_limit_is_refused_by_name(text: str) -> None:
    with pytest.raises(InputError, match=r"HGS_UPLOADS: .*give"):
        UploadLimits.configured(environment={"HGS_UPLOADS": text})


@pytest.mark.parametrize(
    ("check", "status", "words"),
    [
        (lambda limits: limits.check_upload(11, 1), 413, ["11 files", "may have 10", "files=11"]),
        (lambda limits: limits.check_upload(1, 3_000_000_000), 413, ["3.0 GB", "may have 2.0 GB", "upload=3G"]),
        (
            lambda limits: limits.check_file("a.mp4", 1_500_000_000),
            413,
            ["'a.mp4'", "1.5 GB", "have 1.0 GB", "file=2G"],
        ),
        (lambda limits: UploadLimits.configured("off").check_upload(1, 1), 403, ["uploads", "--uploads"]),
    ],
)
def test_a_refusal_names_the_limit_and_the_cure(
    check: Callable[[UploadLimits], None], status: int, words: list[str]
) -> None:
    with pytest.raises(ProblemError) as caught:
        check(UploadLimits(files=10, upload=2 * 1000**3, file=1000**3))
    assert caught.value.status == status
    assert [word for word in words if word not in caught.value.detail] == []


def test_sizes_are_told_in_powers_of_1000() -> None:
    assert [bytes_for_people(size) for size in (0, 999, 1500, 2 * 1000**4)] == [
        "0 bytes",
        "999 bytes",
        "1.5 kB",
        "2.0 TB",
    ]
