from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from jobs.queue.job_request import JobRequest


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"title": "x" * 201}, "title"),
        ({"title": "a\0b"}, "title"),
        ({"title": "\ud800"}, "title"),
        ({"title": "two\nlines"}, "title"),
        ({"title": "\x1b[2J"}, "title"),
        ({"given": GivenFiles(masks=Path("a\udc80"))}, "masks"),
        ({"capture": Path("a\udc80")}, "capture"),
        ({"capture": Path("a" * 5000)}, "capture"),
        ({"given": GivenFiles(audio="a\0b")}, "audio"),
        ({"labels": ("two words",)}, "labels"),
        ({"priority": 101}, "priority"),
        ({"priority": -101}, "priority"),
        ({"time_limit": -1.0}, "time_limit"),
        ({"time_limit": math.nan}, "time_limit"),
        ({"time_limit": math.inf}, "time_limit"),
        ({"key": "two words"}, "key"),
        ({"key": "x" * 256}, "key"),
    ],
)
def test_text_that_cannot_be_stored_or_shown_is_refused_by_name(
    tmp_path: Path, fields: dict[str, Any], field: str
) -> None:
    with pytest.raises(InputError) as refused:
        JobRequest(**{"capture": tmp_path, "config": RunConfig(), **fields})
    assert refused.value.field == field
    str(refused.value).encode()


def test_the_digest_is_of_all_that_is_asked_for(tmp_path: Path) -> None:
    changes: list[dict[str, Any]] = [
        {"title": "A"},
        {"labels": ("a",)},
        {"priority": 1},
        {"time_limit": 5.0},
        {"given": GivenFiles(masks=tmp_path)},
        {"given": GivenFiles(depth=tmp_path)},
        {"given": GivenFiles(mesh=tmp_path)},
        {"given": GivenFiles(audio="none")},
        {"config": RunConfig().changed({"train.iterations": 7})},
        {"capture": tmp_path / "b"},
    ]
    plain: dict[str, Any] = {"capture": tmp_path, "config": RunConfig()}
    digests = {JobRequest(**plain | change).digest for change in changes}
    assert len(digests | {JobRequest(**plain).digest}) == len(changes) + 1
    assert JobRequest(**plain, key="a").digest == JobRequest(**plain).digest
