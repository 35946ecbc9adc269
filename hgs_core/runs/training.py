"""The training of a run's capture, and its published facts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import ProgressCallback
from hgs_core.decompose.masks import MotionMasks
from hgs_core.native.machine import machine_facts
from hgs_core.points.near_plane import with_near_planes
from hgs_core.points.point_cloud import PointCloud
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.splats import HybridScene
from hgs_core.train.capture_training import TrainingInputs, train_capture

__all__ = ["told_of_training", "train_run"]

_NOT_PUBLISHED = {"machine", "history", "profile"}  # parts of train.json that viewers do not need


def train_run(
    folder: RunFolder, progress: ProgressCallback
) -> tuple[HybridScene[npt.NDArray[np.float32]], dict[str, Any]]:
    """Train from the last checkpoints, or from the points; return the scene and the content of train.json."""
    spec = folder.read_spec()
    config, capture = spec.config, spec.open_capture(cache_bytes=spec.config.capture.cache_bytes)
    points = PointCloud.load(folder.points)
    cameras, masks = with_near_planes(capture.cameras, points.xyz), MotionMasks.load(folder.masks, capture)
    inputs = TrainingInputs(
        capture,
        {i: cameras[i] for i in config.capture.training_cameras(capture)},
        config.train,
        config.seed,
        points,
        capture.frames_in(config.points.interval),
        masks,
    )
    scene, summary = train_capture(inputs, folder.checkpoint, progress, folder.preview)
    return scene, summary | {"machine": machine_facts()}


def told_of_training(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts of a training for a scene's manifest."""
    return {name: value for name, value in summary.items() if name not in _NOT_PUBLISHED}
