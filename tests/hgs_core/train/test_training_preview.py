"""The picture of a training that runs."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from hgs_core.base.progress import Progress
from hgs_core.render.rasterize import rasterize
from hgs_core.train.checkpoint import TrainState, fresh_state
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_preview import Preview
from tests.synthetic import ring_of_cameras, synthetic_scene

CAMERA = ring_of_cameras(3, 64, 48)[0]


@pytest.fixture
def state() -> TrainState:
    return fresh_state(*synthetic_scene(), 3, TrainConfig())


def test_it_shows_what_the_reference_draws_of_the_middle_of_the_time(state: TrainState, tmp_path: Path) -> None:
    Preview(tmp_path / "preview.jpg", CAMERA, TrainConfig()).follow(state, Progress("train", 10, 1000))
    shown = np.asarray(Image.open(io.BytesIO((tmp_path / "preview.jpg").read_bytes())), np.float64) / 255
    with torch.no_grad():
        expected = rasterize(state.static, state.dynamic, CAMERA, 0.5, backend="reference", antialiased=True)
    error = np.abs(shown - expected.rgb.clamp(0, 1).permute(1, 2, 0).numpy()).mean()
    assert error < 0.02  # JPEG's error


def test_it_is_drawn_at_the_first_report_and_at_every_fortieth(
    state: TrainState, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[int] = []
    monkeypatch.setattr("hgs_core.train.training_preview.write_bytes", lambda file, data: written.append(len(data)))
    preview = Preview(tmp_path / "preview.jpg", CAMERA, TrainConfig())
    for done in range(10, 1001, 10):
        preview.follow(state, Progress("train", done, 1000))
    assert len(written) == 41


def test_drawing_changes_nothing_of_the_state(state: TrainState, tmp_path: Path) -> None:
    before = {name: array.clone() for name, array in state.static.items()}
    Preview(tmp_path / "preview.jpg", CAMERA, TrainConfig()).follow(state, Progress("train", 10, 1000))
    assert all(torch.equal(array, before[name]) for name, array in state.static.items())
