"""The compiled sweep against the one in numpy, and both against their docstrings."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points import sweep_costs as module
from hgs_core.points.sweep_costs import BLIND_COST, colour_descriptors, sweep_costs
from hgs_core.scene.camera import Camera

GENERATOR = np.random.default_rng(0)
DEPTHS = 1 / np.linspace(1, 0.1, 24)


def view(x: float, y: float, width: int = 60, height: int = 44) -> Camera:
    pose = np.eye(4)
    pose[:3, 3] = (-x, -y, 0)
    return Camera(f"{x} {y}", width, height, 55, 57, 31, 20, pose)


def picture(camera: Camera) -> np.ndarray:
    return GENERATOR.integers(0, 256, (camera.height, camera.width, 3), np.uint8)


CAMERAS = [view(0, 0), view(0.4, 0), view(-0.3, 0.1, 50, 40), view(0, -3.5)]
PICTURES = [picture(camera) for camera in CAMERAS]
PIXELS = GENERATOR.integers(0, (60, 44), (80, 2))


@pytest.fixture(params=["compiled", "numpy"])
def backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "numpy":
        monkeypatch.setattr(module, "available", lambda: False)


def costs(hull: bool = False, neighbours: int = 3) -> np.ndarray:
    seen = [colour_descriptors(one) for one in PICTURES]
    others = list(zip(CAMERAS, seen, strict=True))[1 : 1 + neighbours]
    own = seen[0][PIXELS[:, 1] * CAMERAS[0].width + PIXELS[:, 0]]
    masks = [(camera, np.asarray(one[..., 0] < 200)) for camera, one in zip(CAMERAS, PICTURES, strict=True)]
    return sweep_costs(CAMERAS[0], CAMERAS[0].rays(PIXELS + 0.5), own, DEPTHS, others, masks if hull else [])


@pytest.mark.parametrize("shape", [(44, 60), (1, 1), (2, 9), (5, 3)])
def test_compiled_descriptors_are_those_of_numpy(shape: tuple[int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = GENERATOR.integers(0, 256, (*shape, 3), np.uint8)
    compiled = colour_descriptors(pixels)
    monkeypatch.setattr(module, "available", lambda: False)
    np.testing.assert_array_equal(compiled, colour_descriptors(pixels))


@pytest.mark.usefixtures("backend")
def test_descriptors_are_means_of_windows_rounded_down() -> None:
    wide = np.pad(PICTURES[0].astype(int), ((3, 3), (3, 3), (0, 0)))
    row, column = 17, 58
    window = wide[row : row + 7, column : column + 7].reshape(-1, 3)
    found = colour_descriptors(PICTURES[0])[row * 60 + column]
    np.testing.assert_array_equal(found[3:], window.sum(0) // 49)
    np.testing.assert_array_equal(found[:3], wide[row + 2 : row + 5, column + 2 : column + 5].sum((0, 1)) // 9)


@pytest.mark.parametrize("hull", [False, True])
@pytest.mark.parametrize("neighbours", [1, 2, 3])
def test_compiled_costs_are_those_of_numpy(hull: bool, neighbours: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = costs(hull, neighbours)
    monkeypatch.setattr(module, "available", lambda: False)
    reference = costs(hull, neighbours)
    assert np.isinf(reference).any() == hull
    # Rounding may put a point on the border of two pixels into either.
    assert (np.isclose(compiled, reference, rtol=1e-5)).mean() > 0.999


@pytest.mark.usefixtures("backend")
def test_the_neighbour_that_fits_worst_does_not_count() -> None:
    own = colour_descriptors(PICTURES[0])
    blank = [np.full_like(own, level) for level in (100, 110, 250)]
    rays = CAMERAS[0].rays(np.array([[30.5, 20.5]]))
    asked = np.full((1, 6), 90, np.uint8)
    found = sweep_costs(CAMERAS[0], rays, asked, np.array([2.0]), [(CAMERAS[0], one) for one in blank], [])
    np.testing.assert_allclose(found, [[15.0]])


@pytest.mark.usefixtures("backend")
def test_a_neighbour_that_sees_nothing_counts_as_unlike() -> None:
    behind = Camera("behind", 60, 44, 55, 57, 31, 20, np.diag([-1.0, 1, -1, 1]))
    rays = CAMERAS[0].rays(np.array([[30.5, 20.5]]))
    descriptors = colour_descriptors(PICTURES[0])
    found = sweep_costs(CAMERAS[0], rays, np.zeros((1, 6), np.uint8), np.array([2.0]), [(behind, descriptors)], [])
    assert found == BLIND_COST
