"""The counts of a change, and its line."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.interchange.changes import Action, Change, most_of_any, nonzero


def test_a_splat_of_which_several_numbers_changed_counts_once() -> None:
    met = np.array([[True, True, False], [False, False, False], [False, False, True]])
    found = Change.where(Action.LIMITED, "scale", met, "")
    assert (found.count, found.of) == (2, 3)
    assert Change.where(Action.LIMITED, "opacity", met[:, 0], "").count == 1


def test_a_rounding_is_what_float32_would_not_do_by_itself() -> None:
    before = np.array([[0.5, 0.5], [1.0, 2e6], [0.0, 3.0], [0.0, 3.0]])
    off = np.array([[0.0, 0.0], [1e-7, 1.0], [2e-6, 0.0], [0.0, -4e-6]])
    found = Change.rounded("position", before, before + off, "24 bits")
    assert (found.action, found.count, found.of) == (Action.ROUNDED, 2, 4)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (Change(Action.LIMITED, "life", 2, 1027, "why"), "life of 2 of 1,027 splats limited: why"),
        (Change(Action.LIMITED, "life", 1027, 1027, "why"), "life of all 1,027 splats limited: why"),
        (Change(Action.LEFT_OUT, "splats", 3, 80, "why"), "3 of 80 splats left out: why"),
        (Change(Action.LEFT_OUT, "splats", 80, 80, "why"), "all 80 splats left out: why"),
        (Change.whole(Action.REPLACED, "time", "why"), "time replaced: why"),
    ],
)
def test_a_change_is_said_in_one_line(change: Change, line: str) -> None:
    assert str(change) == line


def test_what_met_no_splat_is_left_out_and_what_met_the_whole_is_not() -> None:
    none, some = (Change(Action.ROUNDED, "colour", count, 9, "") for count in (0, 1))
    whole = Change.whole(Action.LEFT_OUT, "background", "")
    assert nonzero([none, some, whole]) == (some, whole)


def test_the_plain_form_has_the_action_as_a_word() -> None:
    found = Change(Action.LEFT_OUT, "splats", 3, 80, "they are never seen").to_json()
    assert found == {"action": "left out", "what": "splats", "count": 3, "of": 80, "reason": "they are never seen"}
    assert type(found["action"]) is str


def test_of_several_files_each_kind_is_told_once_with_the_most_splats() -> None:
    few, many = (Change(Action.LIMITED, "colour", count, 9, "to 0") for count in (2, 5))
    whole = Change.whole(Action.LEFT_OUT, "animations", "none")
    assert most_of_any([few, whole, many, few, whole]) == (many, whole)
