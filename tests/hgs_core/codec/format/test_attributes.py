"""The table of attributes against that of docs/format.md."""

from __future__ import annotations

import re

import numpy as np
import pytest

from hgs_core.codec.format.attributes import ATTRIBUTES, BY_ID, LARGEST_FORM, MOTION_ORDERS
from tests.conftest import REPOSITORY

ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in re.findall(r"^\| \d+ \| [a-z_]+ \|.*\|$", (REPOSITORY / "docs" / "format.md").read_text(), re.M)
]
FORMS = [*range(8), 11, 15]
HOLDS = {
    "N": lambda form: True,
    "form mod 4 >= 1": lambda form: form % 4 >= 1,
    "form mod 4 >= 2": lambda form: form % 4 >= 2,
    "form mod 4 = 3": lambda form: form % 4 == 3,
    "form mod 8 >= 4": lambda form: form % 8 >= 4,
    "form >= 8": lambda form: form >= 8,
}


def test_every_attribute_is_that_of_the_specification() -> None:
    assert list(ATTRIBUTES) == [row[1] for row in ROWS]
    for identity, name, components, transforms, chunk, *_ in ROWS:
        found = ATTRIBUTES[name]
        assert BY_ID[int(identity)] is found
        assert (found.id, found.components) == (int(identity), int(components)), name
        assert sorted(found.transforms) == [int(number) for number in transforms.split(",")], name
        assert found.dynamic_only == chunk.startswith("dynamic"), name
        assert found.version == (3 if "version 3" in chunk else 2), name


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_rows_belong_to_the_forms_that_the_specification_names(dtype: type) -> None:
    for row in ROWS:
        found = ATTRIBUTES[row[1]].among(np.array(FORMS, dtype))
        assert found.tolist() == [HOLDS[row[5]](form) for form in FORMS], row[1]


@pytest.mark.parametrize(("bits", "morton", "others"), [(1, 1, 3), (8, 3, 3), (9, 4, 6), (21, 8, 9), (24, 9, 9)])
def test_a_row_has_whole_bytes_a_component_and_places_are_interleaved_before(
    bits: int, morton: int, others: int
) -> None:
    assert ATTRIBUTES["position"].planes(bits) == morton
    assert ATTRIBUTES["rgb"].planes(bits) == others
    assert ATTRIBUTES["opacity"].planes(bits) == others / 3


def test_orders_of_motion_and_largest_forms_follow_from_the_table() -> None:
    assert [row[1] for row in ROWS if re.match(r"m[1-5] ", row[6])] == list(MOTION_ORDERS)
    assert LARGEST_FORM == {2: 7, 3: 15}
