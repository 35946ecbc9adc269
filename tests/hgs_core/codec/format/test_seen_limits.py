"""The reference is numpy's interpolation along one axis after the other."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.captured_space import CapturedSpace, Place
from hgs_core.codec.format.json_fields import field_of
from hgs_core.codec.format.seen_limits import SeenLimits
from tests.conftest import REPOSITORY
from tests.json_faults import put

VECTORS = REPOSITORY / "tests" / "vectors"
CASES = [case for case in json.loads((VECTORS / "captured_space.json").read_text()) if "seen" in case["captured_space"]]
INVALID = json.loads((VECTORS / "invalid_seen.json").read_text())
BOX = (-0.4, 0.9)  # elevations


def limits(columns: int, rows: int) -> SeenLimits:
    rng = np.random.default_rng(0)
    elevations = np.sort(rng.uniform(*BOX, (columns, 2)))
    distances = np.sort(rng.uniform(1, 3, (columns, rows, 2)))
    return SeenLimits(
        tuple((float(a), float(b)) for a, b in elevations),
        tuple(tuple((float(a), float(b)) for a, b in column) for column in distances),
    )


@pytest.mark.parametrize("half", [0.8, None])
def test_between_the_nodes_limits_are_interpolated(half: float | None) -> None:
    seen = limits(5, 4)
    azimuths = np.linspace(-half, half, 5) if half else np.arange(5) / 5 * 2 * math.pi

    def at(azimuth: float, ends: np.ndarray) -> float:
        return float(np.interp(azimuth, azimuths, ends, period=None if half else 2 * math.pi))

    for azimuth in np.linspace(-0.8, 0.8, 9):
        expected = [at(azimuth, ends) for ends in np.array(seen.elevations).T]
        assert seen.elevation(azimuth, half) == pytest.approx(expected)
        for elevation in np.linspace(*BOX, 7):
            rows = [[at(azimuth, ends) for ends in row.T] for row in np.array(seen.distances).transpose(1, 0, 2)]
            expected = [float(np.interp(elevation, np.linspace(*BOX, 4), ends)) for ends in np.transpose(rows)]
            assert seen.distance(azimuth, elevation, half, BOX) == pytest.approx(expected)


def test_limits_do_not_jump_where_a_turn_ends() -> None:
    seen = limits(6, 3)
    for azimuth in (math.pi, 0.0):
        before, after = (seen.elevation(azimuth + step, None) for step in (-1e-9, 1e-9 - 2 * math.pi))
        assert before == pytest.approx(after, abs=1e-7)


def test_a_space_of_a_single_elevation_has_the_distances_of_the_first_row() -> None:
    seen = limits(2, 2)
    assert seen.distance(-1.0, 0.3, 1.0, (0.3, 0.3)) == pytest.approx(seen.distances[0][0])


@pytest.mark.parametrize("case", CASES, ids=lambda case: str(case["center"]))
def test_the_plain_form_survives_reading_and_writing(case: dict[str, Any]) -> None:
    document = case["captured_space"]
    assert CapturedSpace.read(field_of(document, "space")).to_json() == document


def test_without_limits_a_space_is_the_box_that_it_was() -> None:
    document = {name: value for name, value in CASES[0]["captured_space"].items() if name != "seen"}
    space = CapturedSpace.read(field_of(document, "space"))
    assert space.seen is None
    assert "seen" not in space.to_json()
    assert space.holds(Place(0.69, 0.29, 2.4))


def test_a_space_that_is_open_all_round_stays_so() -> None:
    document = CASES[1]["captured_space"]
    closed = document | {"seen": document["seen"] | {"azimuth": [-1.0, 1.0]}}
    with pytest.raises(InputError, match=r"space\.seen\.azimuth: is given for .* all round; leave it out"):
        CapturedSpace.read(field_of(closed, "space"))


@pytest.mark.parametrize("case", INVALID, ids=str)
def test_the_wrong_field_is_named(case: dict[str, Any]) -> None:
    document = json.loads(json.dumps(CASES[0]["captured_space"]))
    put(document["seen"], case)
    with pytest.raises(InputError) as raised:
        CapturedSpace.read(field_of(document, "space"))
    assert raised.value.where == f"space.{case['field']}"
