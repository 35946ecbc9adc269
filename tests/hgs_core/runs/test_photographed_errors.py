"""Pictures of a capture tell how splats are drawn that are thinner than its pixels."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hgs_core.capture.open import open_capture
from hgs_core.render.rasterize import rasterize
from hgs_core.runs.photographed_errors import photographed_errors
from hgs_core.runs.run_config import RunConfig
from hgs_core.scene import HybridScene, Segment
from tests.synthetic import synthetic_scene, write_capture


@pytest.mark.parametrize("truth", [True, False])
def test_the_way_that_a_scene_was_drawn_is_nearer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, truth: bool) -> None:
    write_capture(tmp_path)
    static, dynamic = synthetic_scene()
    thin = dataclasses.replace(static, log_scales=static.log_scales - 3)
    scene = HybridScene(thin, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    asked = []

    def picture(capture: Any, index: int, frame: int, camera: Any) -> torch.Tensor:
        asked.append(index)
        tensors = scene.map(torch.from_numpy)
        segment = tensors.segments[0]
        moment = segment.normalised(capture.moment(index, frame))
        return rasterize(tensors.static, segment.dynamic, camera, moment, antialiased=truth, gradients="none").rgb

    monkeypatch.setattr("hgs_core.runs.photographed_errors.target_picture", picture)
    config = RunConfig.from_json({"preset": "imported", "capture.hold_out": ["2"]})
    found = photographed_errors(scene, open_capture(tmp_path), config)
    assert found[truth] < 1e-6
    assert -10 * np.log10(found[not truth]) < 60
    assert 2 not in asked
