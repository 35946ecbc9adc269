"""Values of a JSON document are returned in their types, or refused by their path."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.json_fields import field_of

HASH = "0123456789abcdef" * 4


def refused(document: Any, read: str, *arguments: Any) -> str:
    with pytest.raises(InputError) as caught:
        getattr(field_of(document, "file"), read)(*arguments)
    return str(caught.value)


def test_a_value_deep_inside_is_named_by_its_path() -> None:
    root = field_of(json.loads('{"chunks": [{"id": "a"}, {"id": 3}]}'), "manifest.json")
    assert root["chunks"].items()[0]["id"].text() == "a"
    with pytest.raises(InputError, match=r"^manifest\.json\.chunks\[1\]\.id: is 3, expected a string$"):
        root["chunks"].items()[1]["id"].text()
    with pytest.raises(InputError, match=r"^manifest\.json\.chunks\[0\]\.size: is missing$"):
        root["chunks"].items()[0]["size"]


@pytest.mark.parametrize(
    ("read", "value", "arguments"),
    [
        ("text", "", ()),
        ("flag", False, ()),
        ("hash", HASH, ()),
        ("number", -1.5, ()),
        ("number", 3, (3, 2.9)),
        ("whole", 0, (0, 0)),
        ("whole", 1 << 53, (1,)),
        ("mapping", {}, ()),
    ],
)
def test_what_is_of_its_type_and_range_is_returned(read: str, value: Any, arguments: tuple[Any, ...]) -> None:
    assert getattr(field_of(value, "file"), read)(*arguments) == value


@pytest.mark.parametrize(
    ("read", "value", "arguments", "expected"),
    [
        ("mapping", [], (), "an object"),
        ("items", {}, (), "a list"),
        ("items", [1], (2,), "a list of 2"),
        ("text", None, (), "a string"),
        ("flag", 1, (), "true or false"),
        ("hash", HASH.upper(), (), "64 lower-case hex digits"),
        ("hash", HASH + "0", (), "64 lower-case hex digits"),
        ("hash", HASH[:-1] + "\n", (), "64 lower-case hex digits"),
        ("number", True, (), "a finite number"),
        ("number", "1", (), "a finite number"),
        ("number", math.nan, (), "a finite number"),
        ("number", -math.inf, (), "a finite number"),
        ("number", 10**400, (), "a finite number"),
        ("number", 1.9, (2,), "at least 2"),
        ("number", 0.0, (-math.inf, 0), "above 0"),
        ("whole", 1.0, (0,), "a whole number from 0 to 9007199254740992"),
        ("whole", True, (0,), "a whole number from 0 to 9007199254740992"),
        ("whole", -1, (0, 9), "a whole number from 0 to 9"),
        ("whole", 10, (0, 9), "a whole number from 0 to 9"),
    ],
)
def test_what_is_not_is_refused_with_what_was_expected(
    read: str, value: Any, arguments: tuple[Any, ...], expected: str
) -> None:
    assert refused(value, read, *arguments).endswith(f", expected {expected}")


def test_a_wrong_number_in_a_list_is_named() -> None:
    assert field_of([1, 2.5], "box").numbers(2) == (1.0, 2.5)
    assert refused([1, "x", 3], "numbers", 3) == "file[1]: is 'x', expected a finite number"


def test_a_long_value_is_cut() -> None:
    assert refused(["x" * 100], "text") == f"file: is ['{'x' * 35}..., expected a string"
