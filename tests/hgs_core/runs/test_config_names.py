"""Dotted paths become nested mappings; a field is given once."""

from __future__ import annotations

import json
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.config_names import by_stage


@pytest.mark.parametrize(
    "values",
    [
        {"train": {"iterations": 6}, "train.iterations": 5},
        {"train": {"learning_rates": {"rgb": 1}}, "train.learning_rates.rgb": 1},
        {"train.learning_rates": 3, "train.learning_rates.rgb": 1},
        {"train": 3, "train.iterations": 5},
    ],
)
def test_a_field_given_twice_is_refused(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"config\.train.* is given twice; give it once"):
        by_stage(values)


def test_parts_may_be_given_in_pieces_and_what_is_given_stays_as_it_is() -> None:
    given = {
        "train": {"learning_rates": {"rgb": 1}},
        "train.learning_rates": {"opacity": 2},
        "train.dssim": 0.1,
        "seed": 3,
    }
    before = json.dumps(given)
    assert by_stage(given) == {"train": {"learning_rates": {"rgb": 1, "opacity": 2}, "dssim": 0.1}, "seed": 3}
    assert json.dumps(given) == before
