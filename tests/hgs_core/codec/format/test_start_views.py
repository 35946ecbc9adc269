from __future__ import annotations

import json
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest_reading import read_manifest
from tests.hgs_core.codec.format.test_manifest import document

BOX = [10.0, -5.0, 300.0, 220.5]


def started(**changes: Any) -> dict[str, Any]:
    found = document()
    wide = {"camera": found["cameras"][0]["name"], "box": BOX}
    return found | {"start_views": [wide, wide | changes]}


def test_the_views_survive_reading_and_writing() -> None:
    manifest = read_manifest(started())
    assert manifest.start_views is not None
    assert manifest.start_views.tall.box == tuple(BOX)
    assert json.loads(json.dumps(manifest.to_json()))["start_views"] == started()["start_views"]


def test_a_manifest_may_lack_them() -> None:
    assert read_manifest(document()).start_views is None
    assert "start_views" not in read_manifest(document()).to_json()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"camera": "nobody"}, r"start_views\[1\].camera: is 'nobody', expected one of"),
        ({"box": [3, 0, 3, 1]}, r"start_views\[1\].box: is \[3, 0, 3, 1\], expected left, top, right and bottom"),
        ({"box": [3, 0, 4]}, r"start_views\[1\].box"),
        ({"box": [0, float("nan"), 4, 5]}, r"start_views\[1\].box"),
    ],
)
def test_wrong_views_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_manifest(started(**changes))
