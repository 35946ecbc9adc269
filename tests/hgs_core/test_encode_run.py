from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.capture.open import open_capture
from hgs_core.codec import EncodeSettings
from hgs_core.encode_run import fitting_settings, measure_utility
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import HybridScene, Segment
from hgs_core.train.config import BUDGETS
from tests.synthetic import synthetic_scene, write_capture


def scene() -> HybridScene[np.ndarray]:
    static, dynamic = synthetic_scene()
    return HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())


def test_utility_is_what_the_squared_error_grows_by_when_a_colour_changes(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path, cameras=3, frames=2)
    given = scene()
    times = np.array([0.0, 5 / 30])
    utility = measure_utility(given, cameras, times, antialiased=False)
    assert (len(utility.static), len(utility.dynamic[0])) == (150, 3)
    largest = int(utility.static.argmax())
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
    assert 0.5 * growth <= utility.static[largest] <= 2 * growth


@pytest.mark.parametrize(("harm", "expected"), [(0.0, 8.0), (1.0, 0.25)])
def test_settings_are_as_coarse_as_the_budget_allows(tmp_path: Path, harm: float, expected: float) -> None:
    cameras = write_capture(tmp_path)
    given = scene()

    def encoded(settings: EncodeSettings) -> HybridScene[np.ndarray]:
        return given.map(lambda array: (array + harm).astype(np.float32))

    found = fitting_settings(
        given, encoded, open_capture(tmp_path), dict(enumerate(cameras)), "default", antialiased=False
    )
    assert BUDGETS["default"] == 0.1
    assert found.coarseness == pytest.approx(expected, rel=0.15)
