from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from jobs.home.stage_limits import StageLimits
from jobs.home.stage_settings import StageBytes, StageCount, StageSeconds


def test_silence_is_a_positive_number_of_seconds() -> None:
    assert StageLimits.from_environment({"HGS_STAGE_SILENCE": "90"}).silence == StageSeconds(90.0)
    assert StageLimits.from_environment({"HGS_STAGE_REPORT": "90"}).report == StageSeconds(90.0)
    for wrong in ("0", "-1", "nan", "inf", "soon"):
        with pytest.raises(InputError, match=f"HGS_STAGE_SILENCE: '{wrong}' is not a positive number of seconds"):
            StageLimits.from_environment({"HGS_STAGE_SILENCE": wrong})


@pytest.mark.parametrize("field", ["processes", "files"])
def test_processes_and_files_are_counted(field: str) -> None:
    name = f"HGS_STAGE_{field.upper()}"
    assert getattr(StageLimits.from_environment({name: "90,train=7"}), field) == StageCount(90, (("train", 7),))
    for wrong in ("0", "-1", "1.5", "many"):
        with pytest.raises(
            InputError, match=f"{name}: '{wrong}' is not a positive whole number; write one such as 256"
        ):
            StageLimits.from_environment({name: wrong})


def test_the_longest_file_has_bytes() -> None:
    assert StageLimits.from_environment({"HGS_STAGE_FILE_SIZE": "5G"}).file_size == StageBytes(5e9)
    with pytest.raises(InputError, match="HGS_STAGE_FILE_SIZE: 'large' is no number"):
        StageLimits.from_environment({"HGS_STAGE_FILE_SIZE": "large"})


def test_empty_variables_leave_the_defaults() -> None:
    assert StageLimits.from_environment(dict.fromkeys(StageLimits().environment(), "")) == StageLimits()


def test_a_child_process_reads_the_same_limits() -> None:
    limits = StageLimits(
        StageSeconds(90.0, (("train", 7.5),)),
        StageSeconds(0.5),
        StageBytes(8e9),
        StageCount(9),
        StageCount(8, (("train", 20),)),
        StageBytes(7.0),
    )
    assert StageLimits.from_environment(limits.environment()) == limits
