"""The places of straight pixels on the sensor: blends by the kernel and by numpy, and those that are kept."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.capture.lenses import sensor_places as module
from hgs_core.capture.lenses.lens import Lens, opencv_lens
from hgs_core.capture.lenses.sensor_places import SensorPlaces, sensor_places
from hgs_core.native import library
from hgs_core.scene.camera import Camera

BENT = Camera("bent", 90, 70, 60.0, 61.0, 44.0, 36.0, np.eye(4))
STRAIGHT = Camera("straight", 80, 60, 60.0, 61.0, 39.0, 31.0, np.eye(4))
LENS = opencv_lens([-0.1, 0.02, 1e-3, -5e-4], False)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("lens", [LENS, opencv_lens([-0.02, 0.001], True)])
def test_the_kernel_has_the_bits_of_numpy(lens: Lens, channels: int, monkeypatch: pytest.MonkeyPatch) -> None:
    picture = np.random.default_rng(0).integers(0, 256, (70, 90, channels), dtype=np.uint8)
    places = sensor_places(BENT, lens, STRAIGHT)
    compiled = places.blended(picture)
    monkeypatch.setattr(library, "available", lambda: False)
    monkeypatch.setattr(module, "_STRIP_PIXELS", 1000)
    np.testing.assert_array_equal(places.blended(picture), compiled)


def test_a_blend_is_bilinear() -> None:
    """Against the definition in double precision."""
    picture = np.random.default_rng(1).integers(0, 256, (70, 90, 3), dtype=np.uint8)
    places = sensor_places(BENT, LENS, STRAIGHT)
    top, left = np.divmod(places.corners, 90)
    right, lower = (share.astype(np.float64)[:, None] for share in (places.right, places.lower))
    exact = (1 - lower) * ((1 - right) * picture[top, left] + right * picture[top, left + 1]) + lower * (
        (1 - right) * picture[top + 1, left] + right * picture[top + 1, left + 1]
    )
    assert np.abs(places.blended(picture) - exact).max() <= 0.5 + 1e-4


def test_places_beyond_the_photograph_are_on_its_edge() -> None:
    wide = Camera("wide", 200, 150, 60.0, 61.0, 100.0, 75.0, np.eye(4))
    places = sensor_places(BENT, LENS, wide)
    assert places.corners.min() >= 0
    assert places.corners.max() < 90 * 69 - 1
    assert places.blended(np.full((70, 90, 3), 7, np.uint8)).min() == 7


def test_places_are_found_once_for_a_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_KEPT", type(module._KEPT)())
    first = sensor_places(BENT, LENS, STRAIGHT)
    assert sensor_places(BENT, LENS, STRAIGHT) is first
    other = Camera("other", 79, 60, 60.0, 61.0, 39.0, 31.0, np.eye(4))
    assert sensor_places(BENT, LENS, other) is not first


@pytest.mark.parametrize(("cores", "kept"), [(2, 5), (20, 20)])
def test_kept_places_are_bounded_in_bytes_or_one_for_each_core(
    monkeypatch: pytest.MonkeyPatch, cores: int, kept: int
) -> None:
    places = SensorPlaces(np.zeros(10, np.int32), np.zeros(10, np.float32), np.zeros(10, np.float32))
    monkeypatch.setattr(module, "_KEPT", type(module._KEPT)())
    monkeypatch.setattr(module, "_found", lambda *_: places)
    monkeypatch.setattr(module, "_MOST_KEPT", 5 * 10 * 12)
    monkeypatch.setenv("HGS_THREADS", str(cores))
    for width in range(30):
        sensor_places(Camera("c", width + 2, 60, 60.0, 61.0, 39.0, 31.0, np.eye(4)), LENS, STRAIGHT)
    assert len(module._KEPT) == kept
