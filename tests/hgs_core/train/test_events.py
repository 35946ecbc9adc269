"""A thing that appears between two frames and vanishes between two others: there in time, without a ghost."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render import rasterize
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.splat_sets import joined
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.trainer import Trainer
from tests.synthetic import event_splats, synthetic_scene, write_capture

EVENT = range(6, 11)
FRAMES = 16
HELD_OUT = 3


def still_points() -> PointCloud:
    """The still cloud of the scene, and nothing of the ball."""
    static, _ = synthetic_scene()
    count = len(static)
    nothing = np.zeros(count, np.float32)
    return PointCloud.at_rest(
        static.means.numpy(), static.rgb.numpy(), nothing, nothing, np.full(count, 0.12, np.float32)
    )


@pytest.fixture(scope="module")
def presence(tmp_path_factory: pytest.TempPathFactory) -> npt.NDArray[np.float64]:
    """How much of the ball a held-out camera sees at every frame: 0, as without it; 1, as with it.

    The reference is the scene that the capture was rendered from, with the ball and without.
    """
    path = tmp_path_factory.mktemp("event")
    write_capture(path / "capture", cameras=7, frames=FRAMES, event=EVENT)
    capture = open_capture(path / "capture")
    training = [index for index in range(7) if index != HELD_OUT]
    density = DensityConfig(every=20, max_static=400, max_dynamic=600)
    config = TrainConfig(iterations=400, coarse_until=0.0, density=density)
    (segment,) = cut_into_segments(capture.times, config.segment_frames)
    start = initial_splats(still_points(), segment.clock, 4)
    masks = motion_masks(capture, training, progress=silent)
    cameras = {index: capture.cameras[index] for index in training}
    trainer = Trainer(capture, cameras, config, 0, segment, start, path / "checkpoint.pt", masks=masks)
    trainer.run(silent)
    static, dynamic = trainer.state.static, trainer.state.dynamic
    truth_static, truth_dynamic = synthetic_scene()

    def drawn(static: StaticSplats[torch.Tensor], dynamic: DynamicSplats[torch.Tensor], moment: float) -> torch.Tensor:
        camera = capture.cameras[HELD_OUT]
        return rasterize(static, dynamic, camera, moment, gradients="none", antialiased=config.antialiased).rgb

    shown = []
    for seconds in capture.times:
        moment = segment.clock.normalised(float(seconds))
        without = drawn(truth_static, truth_dynamic, moment)
        ball = drawn(joined(truth_static, event_splats()), truth_dynamic, moment) - without
        shown.append(float(((drawn(static, dynamic, moment) - without) * ball).sum() / ball.square().sum()))
    return np.array(shown)


def test_nothing_is_seen_before_it_appears(presence: npt.NDArray[np.float64]) -> None:
    assert np.abs(presence[: EVENT.start - 1]).max() < 0.1


def test_it_is_there_from_its_second_frame_to_its_last_but_one(presence: npt.NDArray[np.float64]) -> None:
    assert presence[EVENT.start + 1 : EVENT.stop - 1].min() > 0.8


def test_nothing_stays_after_it_has_vanished(presence: npt.NDArray[np.float64]) -> None:
    assert np.abs(presence[EVENT.stop + 1 :]).max() < 0.1
