from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from jobs.home.stage_settings import StageBytes, StageSeconds


def test_stages_have_their_own_number_or_that_of_all() -> None:
    seconds = StageSeconds.parse("LIMIT", "300, train=60,encode=900.5")
    assert [seconds.of(stage) for stage in ("initialise", "train", "encode")] == [300, 60, 900.5]


def test_what_is_written_is_read_again() -> None:
    seconds = StageSeconds(300.0, (("train", 60.0), ("encode", 900.5)))
    assert StageSeconds.parse("LIMIT", str(seconds)) == seconds


@pytest.mark.parametrize("wrong", ["0", "-1", "nan", "inf", "soon", "300,train=", "300,train=0", ""])
def test_anything_but_a_positive_number_is_refused(wrong: str) -> None:
    with pytest.raises(InputError, match=r"LIMIT: '.*' is not a positive number of seconds"):
        StageSeconds.parse("LIMIT", wrong)


def test_an_unknown_stage_is_refused() -> None:
    with pytest.raises(InputError, match="LIMIT: 'trane=60' names no stage; they are initialise, train"):
        StageSeconds.parse("LIMIT", "300,trane=60")


def test_bytes_have_units() -> None:
    memory = StageBytes.parse("LIMIT", "8G,train=24.5G")
    assert [memory.of(stage) for stage in ("encode", "train")] == [8e9, 24.5e9]
    assert StageBytes.parse("LIMIT", str(memory)) == memory
    with pytest.raises(InputError, match="LIMIT: '0' is not a positive number of bytes"):
        StageBytes.parse("LIMIT", "0")
