from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError


@pytest.mark.parametrize(
    ("cure", "line"),
    [("", "run/config.json: seed is -1"), ("give 0 or more", "run/config.json: seed is -1; give 0 or more")],
)
def test_the_message_is_one_line_of_place_problem_and_cure_if_there_is_one(cure: str, line: str) -> None:
    error = InputError(Path("run/config.json"), "seed is -1", cure)
    assert str(error) == line
    assert (error.where, error.problem, error.cure) == ("run/config.json", "seed is -1", cure)
