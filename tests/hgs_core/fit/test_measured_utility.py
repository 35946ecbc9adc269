"""The utility of splats, against the reference rasteriser with one of them changed or left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.codec.encoder.utility import GUESSED_TRANSMITTANCE
from hgs_core.fit import measured_utility
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.low_pass import LOW_PASS
from tests.synthetic import ring_of_cameras, synthetic_scene, write_capture
from tests.worker_threads import threads_of


def test_utility_is_what_the_squared_error_grows_by_when_a_colour_changes(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path, cameras=3, frames=2)
    static, dynamic = synthetic_scene()
    given = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    times = np.array([0.0, 5 / 30])
    utility = measure_utility(given, cameras, times)
    assert (len(utility.static.shown), len(utility.dynamic[0].missed)) == (150, 3)
    largest = int(utility.static.shown.argmax())
    changed = given.static.rgb.copy()
    changed[largest, 0] += 0.01
    growth = 0.0
    for camera in cameras:
        for time in (0.0, 1.0):
            pictures = []
            for rgb in (given.static.rgb, changed):
                static = given.static.map(torch.from_numpy)
                static = type(static)(*(torch.from_numpy(rgb) if name == "rgb" else a for name, a in static.items()))
                dynamic = given.segments[0].dynamic.map(torch.from_numpy)
                pictures.append(rasterize_reference(static, dynamic, View(camera, time, gradients="none")).rgb)
            growth += float(((pictures[1] - pictures[0]) ** 2).sum()) / 0.01**2 / 6
    assert 0.5 * growth <= utility.static.shown[largest] <= 2 * growth


def test_what_is_missed_is_the_squared_error_of_the_pictures_without_the_splat() -> None:
    cameras = ring_of_cameras(3, 64, 48)
    static, dynamic = synthetic_scene()
    given = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),), antialiased=True).map(lambda tensor: tensor.numpy())
    moments = np.array([0.0, 0.5, 1.0])
    measured = measure_utility(given, cameras, np.tile(moments * 5 / 30, 7))

    def pictures(static_rows: np.ndarray, dynamic_rows: np.ndarray) -> list[torch.Tensor]:
        return [
            rasterize_reference(
                static.take(static_rows),
                dynamic.take(dynamic_rows),
                View(camera, float(moment), antialiased=True, gradients="none"),
            ).rgb
            for camera in cameras
            for moment in moments
        ]

    everyone = np.arange(len(static)), np.arange(len(dynamic))
    whole = pictures(*everyone)

    def missed(static_rows: np.ndarray, dynamic_rows: np.ndarray) -> float:
        others = pictures(static_rows, dynamic_rows)
        return float(np.mean([float(((a - b) ** 2).sum()) for a, b in zip(whole, others, strict=True)]))

    ranked = np.argsort(measured.static.missed)
    for splat in ranked[[-1, -40]]:
        without = missed(np.delete(everyone[0], splat), everyone[1])
        assert 0.5 * without <= measured.static.missed[splat] <= 2 * without
    for splat in everyone[1]:
        without = missed(everyone[0], np.delete(everyone[1], splat))
        assert 0.4 * without <= measured.dynamic[0].missed[splat] <= 2.5 * without


def ball(place: float, colour: float, opacity: float = 4.0) -> StaticSplats[np.ndarray]:
    """A round splat of standard deviation 0.1 on the z axis."""
    arrays = [[0, 0, place]], np.full((1, 3), np.log(0.1)), [[1, 0, 0, 0]], [opacity], np.full((1, 3), colour)
    return StaticSplats(*(np.array(array, np.float32) for array in arrays))


def still(*parts: StaticSplats[np.ndarray]) -> HybridScene[np.ndarray]:
    arrays = ([getattr(part, name) for part in parts] for name, _ in parts[0].items())
    return HybridScene(StaticSplats(*map(np.concatenate, arrays)), (Segment(0.0, 2.0, DynamicSplats.empty()),))


def test_black_before_nothing_is_missed_where_the_background_may_be_any() -> None:
    cameras = ring_of_cameras(3, 64, 48)
    given, often = still(ball(0.0, 0.0)), np.arange(60) / 30
    on_black = measure_utility(given, cameras, often).static.missed
    on_any = measure_utility(given, cameras, often, any_background=True).static.missed
    white = measure_utility(still(ball(0.0, 1.0)), cameras, often).static.missed
    assert on_black[0] < 1e-9
    # As much as white on black where it is on white, and nothing on black; 60 views of one splat tell that roughly.
    assert 0.25 * white[0] < on_any[0] < white[0]


def test_what_no_picture_shows_is_missed_without_limit_and_shows_by_its_size() -> None:
    """Two splats out of every picture, one of them ten times as near, and one that is seen."""
    cameras = ring_of_cameras(3, 64, 48)
    given = still(ball(0.0, 1.0), ball(-50.0, 1.0), ball(-500.0, 1.0))
    found = measure_utility(given, cameras, np.zeros(1)).static
    assert 0 < found.missed[0] < np.inf
    assert np.isinf(found.missed[1:]).all()
    for shown, place in zip(found.shown[1:], (-50.0, -500.0), strict=True):
        near = min(np.linalg.norm(camera.position - [0, 0, place]) for camera in cameras)
        area = np.pi * ((0.1 * cameras[0].fx / near) ** 2 + LOW_PASS)
        alpha = GUESSED_TRANSMITTANCE / (1 + np.exp(-4.0))
        np.testing.assert_allclose(shown, area * alpha**2 / 5, rtol=1e-3)  # three pictures and two more


@pytest.mark.parametrize("any_background", [False, True])
def test_views_are_drawn_on_all_cores_to_the_same_bits(monkeypatch: pytest.MonkeyPatch, any_background: bool) -> None:
    threads = threads_of(monkeypatch, measured_utility, "rasterize")
    static, dynamic = synthetic_scene()
    given = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    found = []
    for count in ("1", "4"):
        monkeypatch.setenv("HGS_THREADS", count)
        times = np.linspace(0, 5 / 30, 20)
        found.append(measure_utility(given, ring_of_cameras(4, 64, 48), times, any_background=any_background))
    for alone, together in zip((found[0].static, *found[0].dynamic), (found[1].static, *found[1].dynamic), strict=True):
        np.testing.assert_array_equal(alone.shown, together.shown)
        np.testing.assert_array_equal(alone.missed, together.missed)
    assert threads
    assert "MainThread" not in threads
