"""The reference is how scripts/make_vectors.py puts the places: along the axes of the frame, by sine and cosine."""

from __future__ import annotations

import json
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.json_fields import field_of
from tests.conftest import REPOSITORY

CASES = json.loads((REPOSITORY / "tests" / "vectors" / "captured_space.json").read_text())


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case['center']}")
def test_places_have_the_numbers_by_which_they_were_put(case: dict[str, Any]) -> None:
    space = CapturedSpace.read(field_of(case["captured_space"], "space"))
    for expected in case["places"]:
        place = space.place(expected["eye"], case["center"], case["up"])
        assert vars(place) == pytest.approx({name: expected[name] for name in vars(place)}, abs=1e-12)
        assert space.holds(place) is expected["inside"]


def test_a_space_is_read_as_it_was_written() -> None:
    space = CapturedSpace(
        (1.0, 0.0, 0.0), None, (-1.0, 1.6), (1.0, 3.0), None, ((0.6, 0.8, 0.0), (0.0, 0.0, 1.0)), True
    )
    assert CapturedSpace.read(field_of(space.to_json(), "space")) == space


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("cones", [[0, 0, 1], [0, 0, 2]], r"cones\[1\]: has the length 2, expected 1"),
        ("cones", [[0, 1]], r"cones\[0\]"),
        ("subject_only", 1, "subject_only"),
    ],
)
def test_invalid_cones_are_refused_by_name(field: str, value: object, problem: str) -> None:
    document = CapturedSpace((1.0, 0.0, 0.0), 0.5, (-1.0, 1.6), (1.0, 3.0)).to_json() | {field: value}
    with pytest.raises(InputError, match=problem):
        CapturedSpace.read(field_of(document, "space"))


def test_what_is_straight_above_has_an_azimuth_too() -> None:
    space = CapturedSpace((1.0, 0.0, 0.0), 0.5, (-1.0, 1.6), (1.0, 3.0))
    place = space.place([0, 0, 2], [0, 0, 0], [0, 0, 1])
    assert (place.azimuth, place.elevation, place.distance) == (0.0, pytest.approx(1.5707963), 2.0)
    assert space.holds(place)
