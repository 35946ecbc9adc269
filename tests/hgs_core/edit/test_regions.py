from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit.regions import ball_of, box_of

EIGHTH = [np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)]  # 45 degrees about z


def test_a_box_holds_what_lies_between_its_faces() -> None:
    box = box_of([1, 0, 0, 2, 4, 6])
    assert box.contains(np.array([[1, 0, 0], [2, 2, 3], [2.01, 0, 0], [1, -2.01, 0], [1, 0, 3.01]])).tolist() == [
        True,
        True,
        False,
        False,
        False,
    ]


def test_a_turned_box_reaches_along_its_own_axes() -> None:
    """Turned by 45 degrees about z, a long x axis lies along (1, 1, 0)."""
    box = box_of([0, 0, 0, 4, 0.2, 1, *EIGHTH])
    assert box.contains(np.array([[1.3, 1.3, 0], [1.3, -1.3, 0], [1.9, 0, 0]])).tolist() == [True, False, False]


def test_a_ball_holds_what_is_near_its_middle() -> None:
    ball = ball_of([1, 1, 1, 2])
    assert ball.contains(np.array([[1, 1, 3], [1, 1, 3.01], [0, 0, 0]])).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("make", "numbers", "problem"),
    [
        (box_of, [0, 0, 0, 1, 1], "--box: has 5 finite numbers"),
        (box_of, [0, 0, 0, 1, 0, 1], "--box: a side of 0 is not positive"),
        (box_of, [0, 0, 0, 1, 1, 1, 0, 0, 0, 0], "--box: its quaternion has no length"),
        (ball_of, [0, 0, 0], "--sphere: has 3 finite numbers"),
        (ball_of, [0, 0, 0, -1], "--sphere: a radius of -1 is not positive"),
    ],
)
def test_what_is_no_region_is_refused(make, numbers: list[float], problem: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=problem):
        make(numbers)
