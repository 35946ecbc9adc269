from __future__ import annotations

from dataclasses import dataclass, field

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
