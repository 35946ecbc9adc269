"""Camera paths: their curve against its definition, and their file."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.film.camera_path import CameraPath, KeyFrame, load_camera_path
from scripts.make_picture_vectors import VECTORS, camera_path

UP = (0.0, -1.0, 0.0)


def key(time: float, x: float = 0.0, fov: float = 50.0) -> KeyFrame:
    return KeyFrame(time, (x, 0.0, -3.0), (x / 2, 0.0, 0.0), fov)


def document(**changes: Any) -> dict[str, Any]:
    return CameraPath((key(0.0), key(1.0, 1.0), key(3.0, 4.0, 70.0))).to_json() | changes


def test_the_vectors_for_the_player_are_its_cameras() -> None:
    vectors, made = json.loads((VECTORS / "camera_path.json").read_text()), camera_path()
    assert vectors["path"] == made["path"]
    for vector, found in zip(vectors["cameras"], made["cameras"], strict=True):
        for name, values in vector.items():
            np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-12)


def test_it_stands_at_its_key_frames() -> None:
    path = CameraPath((key(0.0), key(1.0, 1.0), key(3.0, 4.0, 70.0)))
    for one in path.keys:
        camera = path.camera(one.time, (64, 48), UP)
        np.testing.assert_allclose(camera.position, one.position, atol=1e-12)
        assert math.degrees(2 * math.atan(24 / camera.fy)) == pytest.approx(one.vertical_fov)
        pixels, _ = camera.project(np.array([one.target]))
        np.testing.assert_allclose(pixels, [[32, 24]], atol=1e-9)


@given(st.floats(0, 3), st.floats(-2, 2))
def test_even_motion_stays_even(time: float, speed: float) -> None:
    """Reference: the straight line, through key frames at uneven times."""
    path = CameraPath(tuple(key(at, speed * at) for at in (0.0, 0.5, 1.5, 3.0)))
    np.testing.assert_allclose(path.camera(time, (64, 48), UP).position, [speed * time, 0, -3], atol=1e-9)


def test_its_speed_does_not_jump_at_a_key_frame() -> None:
    path = CameraPath((key(0.0), key(1.0, 1.0), key(3.0, 0.5), key(4.0, 2.0)))
    before, here, after = (path.camera(1.0 + step, (64, 48), UP).position[0] for step in (-1e-5, 0.0, 1e-5))
    assert here - before == pytest.approx(after - here, abs=1e-8)


def test_it_stands_still_before_and_after() -> None:
    path = CameraPath((key(1.0, 1.0), key(2.0, 2.0)))
    assert path.camera(0.0, (64, 48), UP).position[0] == 1.0
    assert path.camera(9.0, (64, 48), UP).position[0] == 2.0


def test_what_is_too_near_is_not_drawn() -> None:
    path = CameraPath((key(0.0),))
    assert path.camera(0.0, (64, 48), UP).near == pytest.approx(0.45)
    assert path.camera(0.0, (64, 48), UP, near=1.0).near == 1.0


def test_a_camera_that_meets_its_target_is_refused() -> None:
    path = CameraPath((KeyFrame(0, (0, 0, -1), (0, 0, 1), 50), KeyFrame(1, (0, 0, 1), (0, 0, -1), 50)))
    with pytest.raises(InputError, match=r"camera path at 0\.500 s: the camera is at its own target"):
        path.camera(0.5, (64, 48), UP)
    with pytest.raises(InputError, match="straight up or down"):
        CameraPath((KeyFrame(0, (0, -3, 0), (0, 0, 0), 50),)).camera(0, (64, 48), UP)


def test_a_file_gives_the_path_that_was_written(tmp_path: Path) -> None:
    (tmp_path / "path.json").write_text(json.dumps(document()))
    assert load_camera_path(tmp_path / "path.json").to_json() == document()


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"format": "x"}, "format"),
        ({"version": 2}, "version"),
        ({"keys": []}, "keys: is empty"),
        ({"keys": [key(1.0).to_json(), key(1.0).to_json()]}, r"keys\[1\]\.time: is 1, not after the one before"),
        ({"keys": [key(0.0).to_json() | {"vertical_fov": 180}]}, r"keys\[0\]\.vertical_fov: is 180"),
        ({"keys": [key(0.0).to_json() | {"target": [0, 0, -3]}]}, r"keys\[0\]\.target"),
        ({"keys": [key(0.0).to_json() | {"position": [0, math.inf, 0]}]}, r"keys\[0\]\.position\[1\]"),
    ],
)
def test_a_wrong_field_is_named(changes: dict[str, Any], told: str, tmp_path: Path) -> None:
    (tmp_path / "path.json").write_text(json.dumps(document(**changes)))
    with pytest.raises(InputError, match=told):
        load_camera_path(tmp_path / "path.json")


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "\ud800".encode("utf-8", "surrogatepass").decode("latin-1")])
def test_a_file_that_is_no_json_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "path.json").write_text(text)
    with pytest.raises(InputError, match="is no JSON"):
        load_camera_path(tmp_path / "path.json")


@pytest.mark.parametrize("text", ["{}", "[]", "7", '{"keys": []}'])
def test_a_file_of_something_else_is_refused_with_the_document(text: str, tmp_path: Path) -> None:
    (tmp_path / "path.json").write_text(text)
    with pytest.raises(InputError, match=r"path\.json: is no camera path: .*; write it as docs/interchange.md says"):
        load_camera_path(tmp_path / "path.json")
