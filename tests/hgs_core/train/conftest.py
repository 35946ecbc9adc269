"""A synthetic capture with masks, and the means to apply one round to a state."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch

from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import MotionMasks, motion_masks
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState, fresh_state
from hgs_core.train.control import Round, RoundContext
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import CaptureSegment, cut_into_segments
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews
from tests.synthetic import write_capture

CONFIG = TrainConfig(colour_correction=False, density=DensityConfig(max_dynamic=100))
"""The config of `state_of`; rounds may have another."""

Apply = Callable[[Round, TrainState, TrainConfig], None]


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return open_capture(path)


@pytest.fixture(scope="module")
def masks(capture: Capture) -> MotionMasks:
    return motion_masks(capture, range(len(capture.cameras)), progress=silent)


@pytest.fixture(scope="module")
def segment(capture: Capture) -> CaptureSegment:
    return cut_into_segments(capture.times, 100)[0]


@pytest.fixture
def views(capture: Capture, masks: MotionMasks, segment: CaptureSegment) -> TrainingViews:
    return TrainingViews(capture, dict(enumerate(capture.cameras)), CONFIG, segment, masks, 0)


def state_of(static: StaticSplats[torch.Tensor], dynamic: DynamicSplats[torch.Tensor]) -> TrainState:
    return fresh_state(static, dynamic, 5, CONFIG)


@pytest.fixture
def applied(views: TrainingViews, segment: CaptureSegment) -> Callable[..., None]:
    """Return a function that applies a round after the first iteration and looks whether all rows still agree."""

    def apply(control: Round, state: TrainState, config: TrainConfig = CONFIG, *, statics_learn: bool = True) -> None:
        schedule = Schedule(config, extent=1.0, frames=6)
        counts = len(state.static), len(state.dynamic)
        control.apply(state, RoundContext(0, 0, schedule, views, segment, views.cameras[0], counts, statics_learn))
        assert len(state.static_optimiser.moments) == len(state.static)
        assert len(state.dynamic_optimiser.moments) == len(state.dynamic)
        assert len(state.statistics.count) == len(state.static) + len(state.dynamic)

    return apply
