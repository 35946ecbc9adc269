from __future__ import annotations

import pytest

from benchmarks.refusals import refusing
from hgs_core.base.errors import InputError


def test_a_fault_of_the_input_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    def run() -> int:
        raise InputError("--sizes", "'many' is no size", "give 20k@676x507")

    assert refusing(run) == 2
    assert capsys.readouterr().err == "benchmarks: --sizes: 'many' is no size; give 20k@676x507\n"


def test_a_fault_of_the_program_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        refusing(lambda: 1 // 0)


def test_the_status_is_passed_on() -> None:
    assert refusing(lambda: 3) == 3
