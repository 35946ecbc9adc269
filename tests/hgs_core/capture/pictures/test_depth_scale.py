"""depth.json: the meaning of the values in depth maps."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.depth_scale import Measured, read_depth_scale


def written(folder: Path, value: Any) -> Path:
    (folder / "depth.json").write_text(json.dumps(value))
    return folder


def test_values_become_world_units_and_unknown_ones_0(tmp_path: Path) -> None:
    scale = read_depth_scale(written(tmp_path, {"scale": 0.5, "unknown": 9, "measured": "ray"}))
    assert scale.measured is Measured.RAY
    values = np.array([[2.0, 9.0, -1.0, 0.0, np.nan, np.inf]])
    np.testing.assert_array_equal(scale.distances(values), [[1.0, 0, 0, 0, 0, 0]])


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ({}, r"scale is None"),
        ({"scale": 0}, r"scale is 0, not a number above 0"),
        ({"scale": True}, r"scale is True"),
        ({"scale": "1 mm"}, r"scale is '1 mm'"),
        ({"scale": 1, "measured": "disparity"}, r"measured is 'disparity'; give axis"),
        ({"scale": 1, "unknown": None}, r"unknown is None, not a number"),
        ({"scale": 1, "units": "mm"}, r"has the field 'units'; the fields are scale, measured, unknown"),
        ([0.001], r"holds no object"),
    ],
)
def test_a_wrong_field_is_refused_with_its_value_and_a_cure(tmp_path: Path, value: Any, problem: str) -> None:
    with pytest.raises(InputError, match=rf"depth\.json: {problem}"):
        read_depth_scale(written(tmp_path, value))


def test_a_missing_file_is_refused_with_what_to_write(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r'depth\.json: is missing.*write \{"scale": 0\.001\}'):
        read_depth_scale(tmp_path)
