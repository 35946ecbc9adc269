"""Crops drawn on a scene's page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit.crop import crop
from hgs_core.edit.crop_file import CropFile
from hgs_core.edit.regions import box_of
from hgs_core.edit.trim import trim
from hgs_core.edit.viewed_scene import ViewedScene
from tests.hgs_core.edit.scenes import moving, splats

FILE = Path("edit.json")
BOX = [0.1, 0.0, 0.0, 1.2, 1.2, 1.2, 0.9, 0.1, 0.0, 0.0]


def edited(viewed: ViewedScene, fields: dict[str, Any]) -> ViewedScene:
    asked = CropFile.of(FILE, fields)
    return asked.cropped(asked.trimmed(viewed).viewed).viewed


@pytest.mark.parametrize("inverse", [False, True])
def test_a_side_of_the_box_is_kept_for_a_stretch_of_time(inverse: bool) -> None:
    viewed = moving()
    expected = crop(trim(viewed, 2.5, 4.1).viewed, box_of(BOX), inverse=inverse).viewed
    left = edited(viewed, {"box": BOX, "inverse": inverse, "trim": [2.5, 4.1]})
    assert 0 < splats(left) < splats(viewed)
    np.testing.assert_array_equal(left.scene.static.means, expected.scene.static.means)
    assert (left.begins, len(left.times)) == (expected.begins, len(expected.times))


def test_without_a_stretch_all_of_the_time_is_kept() -> None:
    viewed = moving()
    left = edited(viewed, {"box": BOX[:6]})
    assert (left.scene.start, left.scene.end) == (viewed.scene.start, viewed.scene.end)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"box": None}, "box: is null, not 6 or 10 numbers"),
        ({"box": BOX[:7]}, "box: is .*, not 6 or 10 numbers"),
        ({"box": [*BOX[:5], "1"]}, "box: is .*, not 6 or 10 numbers"),
        ({"box": [*BOX[:5], float("nan")]}, "box: is .*, not 6 or 10 numbers"),
        ({"box": [*BOX[:5], 10**400]}, "box: is .*, not 6 or 10 numbers"),
        ({"box": [*BOX[:5], True]}, "box: is .*, not 6 or 10 numbers"),
        ({"box": [*BOX[:5], -1]}, "box: a side of -1 is not positive"),
        ({"inverse": 1}, "inverse: is 1, not true or false"),
        ({"trim": [1]}, r"trim: is \[1\], not 2 numbers"),
    ],
)
def test_a_wrong_field_is_named(change: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError, match=rf"^edit\.json: {problem}"):
        CropFile.of(FILE, {"box": BOX} | change)


def test_a_box_with_nothing_inside_and_a_stretch_outside_are_named() -> None:
    asked = CropFile.of(FILE, {"box": [99, 0, 0, 1, 1, 1], "trim": [7, 9]})
    with pytest.raises(InputError, match=r"^edit\.json: box: no splat of 240 stays inside of the box"):
        asked.cropped(moving())
    with pytest.raises(InputError, match=r"^edit\.json: trim: 7 to 9 s is no stretch of the scene"):
        asked.trimmed(moving())
