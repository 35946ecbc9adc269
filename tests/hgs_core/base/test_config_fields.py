from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

from hgs_core.base.config_fields import check_fields, flat_fields, with_fields
from hgs_core.base.errors import InputError


@dataclass(frozen=True)
class Part:
    count: int = 3

    def __post_init__(self) -> None:
        check_fields(self, "config.part", {"count": (1, 9)})


@dataclass(frozen=True)
class Whole:
    names: tuple[str, ...] = ()
    part: Part = field(default_factory=Part)

    def __post_init__(self) -> None:
        check_fields(self, "config", {})


def test_fields_of_parts_are_replaced_and_checked() -> None:
    assert with_fields(Whole(), {"names": ["a"], "part": {"count": 5.0}}, "config") == Whole(("a",), Part(5))
    with pytest.raises(InputError, match=r"config\.part\.count: 10 is out of range; give a whole number from 1 to 9"):
        with_fields(Whole(), {"part": {"count": 10}}, "config")


def test_what_is_no_field_or_no_part_is_refused() -> None:
    with pytest.raises(InputError, match=r"config\.part\.size: unknown field; known are count"):
        with_fields(Whole(), {"part": {"size": 1}}, "config")
    with pytest.raises(InputError, match=r"config\.part: 3 is not an object"):
        with_fields(Whole(), {"part": 3}, "config")


def test_fields_are_listed_by_their_paths() -> None:
    assert flat_fields({"a": 1, "b": {"c": 2, "d": {"e": 3}}}) == {"a": 1, "b.c": 2, "b.d.e": 3}


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
