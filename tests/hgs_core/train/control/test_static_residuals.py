"""How the error under static splats varies over time."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render import rasterize
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.control import static_residuals as module
from hgs_core.train.control.static_residuals import temporal_residuals
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView
from tests.synthetic import ring_of_cameras
from tests.worker_threads import threads_of

CAMERAS = ring_of_cameras(2, 64, 48)
NOTHING = DynamicSplats.empty().map(torch.from_numpy)


def two_splats() -> StaticSplats[Tensor]:
    return StaticSplats(
        torch.tensor([[-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]]),
        torch.full((2, 3), -1.6),
        torch.tensor([[1.0, 0, 0, 0]] * 2),
        torch.full((2,), 3.0),
        torch.full((2, 3), 0.5),
    )


def views(static: StaticSplats[Tensor], colours: list[float]) -> list[list[TrainingView]]:
    """Targets in which the second splat has another grey at every moment."""
    result = []
    for place, camera in enumerate(CAMERAS):
        row = []
        for index, grey in enumerate(colours):
            rgb = static.rgb.clone()
            rgb[1] = grey
            changed = StaticSplats(static.means, static.log_scales, static.quats, static.opacity_logits, rgb)
            row.append(TrainingView(place, camera, index / 3, rasterize(changed, None, camera, gradients="none").rgb))
        result.append(row)
    return result


def residuals(colours: list[float]) -> list[float]:
    static = two_splats()
    shown = lambda picture, view: picture  # noqa: E731
    found = temporal_residuals(static, NOTHING, views(static, colours), TrainConfig(), shown)
    return [round(float(value), 3) for value in found]


def test_what_changes_has_a_residual_and_what_stays_has_none() -> None:
    still, changing = residuals([0.1, 0.9, 0.1, 0.9])
    assert still < 0.02
    assert changing > 0.15


def test_an_error_that_never_changes_does_not_count() -> None:
    assert residuals([0.9] * 4) == [0.0, 0.0]


def test_without_views_nothing_is_restless() -> None:
    static = two_splats()
    found = temporal_residuals(static, NOTHING, [], TrainConfig(), lambda picture, view: picture)
    assert found.tolist() == [0.0, 0.0]


def test_cameras_are_judged_on_all_cores_to_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    threads = threads_of(monkeypatch, module, "contributions")
    static = two_splats()
    found = []
    for count in ("1", "4"):
        monkeypatch.setenv("HGS_THREADS", count)
        samples = views(static, [0.1, 0.9, 0.4])
        found.append(temporal_residuals(static, NOTHING, samples, TrainConfig(), lambda picture, _: picture))
    np.testing.assert_array_equal(*found)
    assert found[0].any()
    assert threads
    assert "MainThread" not in threads
