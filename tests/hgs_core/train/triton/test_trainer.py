"""A training by the Triton kernels against one by the backends of the CPU."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene import HybridScene
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.train_config import LabelConfig, TrainConfig
from hgs_core.train.trainer import Trainer
from tests.synthetic import write_capture


def trained(folder: Path, backend: str) -> HybridScene[np.ndarray]:
    density = DensityConfig(every=1, start=0.0, max_static=40, max_dynamic=10, prune_contribution=0.0)
    config = TrainConfig(iterations=2, backend=backend, density=density, labels=LabelConfig(adaptive=False))
    r = np.random.default_rng(0)
    points = PointCloud.at_rest(
        xyz=r.uniform(-1, 1, (25, 3)).astype(np.float32),
        rgb=r.uniform(0, 1, (25, 3)).astype(np.float32),
        times=r.choice([0.0, 0.1], 25).astype(np.float32),
        dynamic=(np.arange(25) % 5 == 0).astype(np.float32),
        spacing=np.full(25, 0.1, np.float32),
    )
    capture = open_capture(folder)
    (segment,) = cut_into_segments(capture.times, config.segment_frames)
    start = initial_splats(points, segment.clock, 2)
    checkpoint = folder / f"{backend}.pt"
    return Trainer(capture, dict(enumerate(capture.cameras[:2])), config, 0, segment, start, checkpoint).run(silent)


def test_both_learn_the_same(tmp_path: Path) -> None:
    write_capture(tmp_path, cameras=3, frames=2, width=32, height=24)
    ours, theirs = trained(tmp_path, "triton"), trained(tmp_path, "auto")
    pairs = [*zip(ours.static.items(), theirs.static.items(), strict=True)]
    pairs += zip(ours.segments[0].dynamic.items(), theirs.segments[0].dynamic.items(), strict=True)
    assert len(ours.static) > 15  # more than the first points: there was density control
    for (name, one), (_, other) in pairs:
        # RMSprop turns the sign of a tiny gradient into a whole step: some parameters differ, most do not.
        assert one.shape == other.shape, name
        assert np.median(np.abs(one - other)) <= 1e-5, name
