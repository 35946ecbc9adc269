from __future__ import annotations

import pickle
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


def test_an_error_goes_from_one_process_to_another() -> None:
    error = InputError("--seed", "is -1", "give 0 or more", field="config.seed")
    copy = pickle.loads(pickle.dumps(error))
    assert (type(copy), str(copy), copy.where, copy.cure) == (InputError, str(error), "--seed", "give 0 or more")
    assert copy.field == "config.seed"


def test_the_name_of_a_field_is_its_place_in_the_message() -> None:
    error = InputError.of_field("title", "is too long")
    assert (error.field, str(error), InputError("title.txt", "is too long").field) == (
        "title",
        "title: is too long",
        "",
    )
