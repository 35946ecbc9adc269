"""COLMAP's camera models against COLMAP itself."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.capture.lenses.colmap_lens import COLMAP_MODELS, PANORAMA, colmap_intrinsics

VALUES = {"f": 300.0, "fx": 300.0, "fy": 310.0, "cx": 190.0, "cy": 155.0, "omega": 0.8, "alpha": 0.5, "beta": 1.1}


def parameters(model: str) -> list[float]:
    r = np.random.default_rng(0)
    return [VALUES.get(name, float(r.uniform(-0.02, 0.02))) for name in COLMAP_MODELS[model][1].split()]


@pytest.mark.parametrize("model", [model for model in COLMAP_MODELS if model != PANORAMA])
def test_rays_meet_the_sensor_where_colmap_has_them(model: str) -> None:
    import pycolmap

    given = parameters(model)
    camera = pycolmap.Camera(model=model, width=400, height=300, params=given, camera_id=1)
    rays = np.random.default_rng(1).uniform(-0.7, 0.7, (50, 2))
    expected = np.array([camera.img_from_cam(np.array([x, y, 1.0])) for x, y in rays])
    fx, fy, cx, cy, lens = colmap_intrinsics(model, given)
    u, v = lens.apply(rays[:, 0], rays[:, 1])
    np.testing.assert_allclose(np.stack((u * fx + cx, v * fy + cy), 1), expected, atol=1e-9)


def test_every_model_of_colmap_is_known_by_its_number() -> None:
    import pycolmap

    known = {
        name: int(number.value) for name, number in pycolmap.CameraModelId.__members__.items() if name != "INVALID"
    }
    assert {name: number for name, (number, _) in COLMAP_MODELS.items()} == known


@pytest.mark.parametrize(
    ("model", "given", "problem"),
    [
        ("NO_LENS", [], "NO_LENS is unknown"),
        (PANORAMA, [400, 200], "is a panorama"),
        ("PINHOLE", [300.0], "PINHOLE has the 4 numbers fx, fy, cx, cy"),
        ("SIMPLE_PINHOLE", [float("nan"), 1.0, 1.0], "has the 3 numbers"),
    ],
)
def test_what_is_no_lens_is_refused(model: str, given: list[float], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        colmap_intrinsics(model, given)
