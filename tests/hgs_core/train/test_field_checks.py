from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.train.field_checks import check_fields, require_known


@dataclass(frozen=True)
class Settings:
    """A field of every kind."""

    count: int = 3
    share: float = 0.5
    kind: str = "plain"
    order: int = 2
    on: bool = True

    def __post_init__(self) -> None:
        check_fields(
            self,
            "settings",
            {"count": (1, 10), "share": (0.0, 1.0)},
            {"kind": ("plain", "fancy", "none"), "order": (2, 5)},
        )


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"count": 0}, "settings.count: 0 is out of range; give a whole number from 1 to 10"),
        ({"count": 11}, "settings.count: 11 is out of range"),
        ({"count": 2.5}, "settings.count: 2.5 is not a whole number"),
        ({"count": True}, "settings.count: True is not a number"),
        ({"count": "3"}, "settings.count: '3' is not a number"),
        ({"share": math.nan}, "settings.share: nan is out of range; give a number from 0.0 to 1.0"),
        ({"share": -0.1}, "settings.share: -0.1 is out of range"),
        ({"share": None}, "settings.share: None is not a number"),
        ({"kind": "other"}, "settings.kind: unknown choice 'other'; use plain, fancy or none"),
        ({"order": 3}, "settings.order: unknown choice 3; use 2 or 5"),
        ({"on": 1}, "settings.on: 1 is not true or false"),
        ({"count": 10**5000}, "settings.count: a number of thousands of digits is out of range"),
        ({"kind": "x" * 99}, "settings.kind: unknown choice 'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx...; use"),
    ],
    ids=lambda value: str(value)[:30] if isinstance(value, str) else "",
)
def test_a_bad_value_is_refused_with_its_field_and_the_cure(given: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError) as caught:
        Settings(**given)
    assert str(caught.value).startswith(problem)


def test_ends_of_a_range_are_inside() -> None:
    assert (Settings(count=1).count, Settings(count=10).count, Settings(share=1).share) == (1, 10, 1.0)


def test_numbers_become_what_their_fields_declare() -> None:
    made = Settings(count=4.0, share=1)  # type: ignore[arg-type]
    assert (type(made.count), type(made.share)) == (int, float)


def test_unknown_names_are_refused_with_those_that_are_known() -> None:
    require_known(Settings, {"count": 1, "on": 2}, "settings")
    with pytest.raises(InputError, match=r"settings\.cuont: unknown field; known are count, kind, on, order, share"):
        require_known(Settings, {"cuont": 1}, "settings")
