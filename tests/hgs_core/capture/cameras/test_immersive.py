"""models.json of Google's Immersive captures: fisheye cameras, straightened."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.immersive import IMMERSIVE
from hgs_core.capture.lenses.lens import Polynomial
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import NAMES, PICTURES


@pytest.fixture
def root(tmp_path: Path) -> Path:
    layouts.immersive(tmp_path)
    PICTURES["videos"](tmp_path)
    return tmp_path


def edit(root: Path, **fields: Any) -> None:
    models = json.loads((root / "models.json").read_text())
    models[1].update(fields)
    (root / "models.json").write_text(json.dumps(models))


def test_poses_and_lenses(root: Path) -> None:
    capture = open_capture(root)
    assert tuple(camera.name for camera in capture.cameras) == NAMES
    for camera, true in zip(capture.cameras, layouts.truth(), strict=True):
        np.testing.assert_allclose(camera.world_to_camera, true.world_to_camera, atol=1e-9)
        assert (camera.fx, camera.fy) == (true.fx, true.fy)
    lens = IMMERSIVE.read(root, root / "models.json").cameras[0].lens
    assert lens == Polynomial(radial=(0.01, -0.002, 0.0), fisheye=True)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"projection_type": "pinhole"}, "camera 1: projection_type is 'pinhole'"),
        ({"position": [1, 2]}, "camera 1: position is"),
        ({"orientation": [0, 0, None]}, "camera 1, orientation: the rotation is"),
        ({"focal_length": -5.0}, "camera 1: focal length .* is not positive"),
        ({"radial_distortion": [-3.0]}, "camera cam02: its distortion coefficients fold the picture"),
    ],
)
def test_bad_values_are_named(root: Path, fields: dict[str, Any], problem: str) -> None:
    edit(root, **fields)
    with pytest.raises(InputError, match=problem):
        open_capture(root)


@pytest.mark.parametrize(
    ("content", "problem"), [("{", "unreadable"), ("{}", "is not a list of cameras"), ("[{}]", "'name' is missing")]
)
def test_damaged_files_are_named(root: Path, content: str, problem: str) -> None:
    (root / "models.json").write_text(content)
    with pytest.raises(InputError, match=rf"models\.json.*{problem}"):
        open_capture(root)
