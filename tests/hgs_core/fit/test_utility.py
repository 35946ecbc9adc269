"""What splats do to pictures, against the reference rasteriser with one of them changed or left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from hgs_core.fit.utility import measure_utility
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import HybridScene, Segment
from tests.synthetic import ring_of_cameras, synthetic_scene, write_capture


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
                static.take(static_rows), dynamic.take(dynamic_rows),
                View(camera, float(moment), antialiased=True, gradients="none"),
            ).rgb
            for camera in cameras for moment in moments
        ]  # fmt: skip

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
