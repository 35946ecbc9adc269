from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import load_manifest
from hgs_core.codec.format.manifest_reading import read_manifest
from tests.conftest import REPOSITORY
from tests.json_faults import put

VECTORS = REPOSITORY / "tests" / "vectors"


def document() -> dict[str, Any]:
    return json.loads((VECTORS / "manifest.json").read_text())


def test_every_field_survives_reading_and_writing() -> None:
    known = {name: value for name, value in document().items() if name != "later"}
    assert read_manifest(document()).to_json() == known


def test_a_manifest_without_the_optional_field_is_one_of_a_scene_that_is_not_antialiased() -> None:
    older = document()
    assert older.pop("antialiased") is True
    assert read_manifest(older).antialiased is False


def test_a_manifest_may_leave_the_size_of_a_unit_unknown() -> None:
    older = document()
    assert older.pop("metres_per_unit") == 0.5
    assert read_manifest(document()).metres_per_unit == 0.5
    assert read_manifest(older).metres_per_unit is None
    assert "metres_per_unit" not in read_manifest(older).to_json()


def test_a_manifest_may_leave_the_captured_space_unknown_or_open_all_round() -> None:
    older = document()
    space = older.pop("captured_space")
    read = read_manifest(older)
    assert read.captured_space is None
    assert "captured_space" not in read.to_json()
    del space["azimuth"]
    dome = read_manifest(older | {"captured_space": space})
    assert dome.captured_space is not None
    assert dome.captured_space.azimuth is None
    assert dome.to_json()["captured_space"] == space


@pytest.mark.parametrize("case", json.loads((VECTORS / "invalid_manifest.json").read_text()), ids=str)
def test_the_wrong_field_is_named(case: dict[str, Any]) -> None:
    changed: Any = document()
    put(changed, case)
    with pytest.raises(InputError) as caught:
        read_manifest(changed)
    assert caught.value.where == case["field"]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 10**400, True, "1"])
def test_a_number_that_is_none_is_refused(value: object) -> None:
    with pytest.raises(InputError, match=r"manifest\.extent: is .*, expected a finite number"):
        read_manifest(document() | {"extent": value})


def test_a_wrong_camera_is_named() -> None:
    changed = document()
    changed["cameras"][0]["fx"] = -1
    with pytest.raises(InputError, match=r"manifest\.cameras\[0\]: camera cam00: focal length"):
        read_manifest(changed)


@pytest.mark.parametrize(
    ("content", "problem"), [(None, "cannot be read"), (b"{", "is not JSON"), (b"[]", "an object")]
)
def test_an_unreadable_file_is_named(tmp_path: Path, content: bytes | None, problem: str) -> None:
    if content is not None:
        (tmp_path / "manifest.json").write_bytes(content)
    with pytest.raises(InputError, match=rf"manifest\.json.*{problem}"):
        load_manifest(tmp_path / "manifest.json")
