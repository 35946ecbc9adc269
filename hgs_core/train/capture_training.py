"""Training a whole capture: the first segment with the statics, then every other one against them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import coefficients_of_order
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.segment_cuts import CaptureSegment, cut_into_segments
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.trainer import Trainer
from hgs_core.train.training_preview import Preview

__all__ = ["TrainingInputs", "segment_trainer", "train_capture"]


@dataclass(frozen=True)
class TrainingInputs:
    """The inputs of a capture's training, the same for all of its segments."""

    capture: Capture
    cameras: Mapping[int, Camera]  # training cameras by their index in the capture, with their near planes
    config: TrainConfig
    seed: int  # seed of all random draws
    points: PointCloud  # labelled first points of the whole capture
    sampled_every: int  # frames between the moments of dynamic points, at most
    masks: MotionMasks | None = None  # masks of the movers; needed where the config's stages are `separate`


def segment_trainer(
    inputs: TrainingInputs, segment: CaptureSegment, checkpoint: Path, after: TrainState | None
) -> Trainer:
    """Return the trainer of one segment of a capture; `checkpoint` and `after` are those of `Trainer`."""
    config = inputs.config
    start = initial_splats(
        segment.points(inputs.points),
        segment.clock,
        len(segment.sampled(inputs.sampled_every)),
        config.labels.initial,
        coefficients=coefficients_of_order(config.motion_order),
    )
    return Trainer(
        inputs.capture,
        inputs.cameras,
        config,
        inputs.seed,
        segment,
        start,
        checkpoint,
        masks=inputs.masks,
        after=after,
    )


def train_capture(
    inputs: TrainingInputs,
    checkpoint: Callable[[int], Path],
    progress: ProgressCallback,
    preview: Path | None = None,
) -> tuple[HybridScene[npt.NDArray[np.float32]], dict[str, Any]]:
    """Train all segments and return the scene and the summary that train.json keeps.

    The statics and the cameras' colour maps are those of the first segment; the others learn their dynamics alone, so
    that they depend on nothing but the first one's end.

    Args:
        inputs: capture, cameras, config and points.
        checkpoint: gives the file of a segment's state; a finished segment's is read, not trained again.
        progress: called as if all segments were one training.
        preview: a JPEG file that shows how far the training is, from the first of these cameras; None: none is drawn.

    Raises:
        StageStopped: the callback asked to stop; the state was saved first.
    """
    config, cameras = inputs.config, inputs.cameras
    segments = cut_into_segments(inputs.capture.times, config.segment_frames)
    total, trained, key = config.iterations * len(segments), [], None
    drawn = None if preview is None else Preview(preview, next(iter(cameras.values())), config)
    for number, segment in enumerate(segments):
        trainer = segment_trainer(inputs, segment, checkpoint(number), None if key is None else key.state)
        before = number * config.iterations

        def report(step: Progress, before: int = before, trainer: Trainer = trainer) -> None:
            whole = dataclasses.replace(step, done=before + step.done, total=total)
            if drawn is not None:
                drawn.follow(trainer.state, whole)
            progress(whole)

        scene = trainer.run(report)
        trained.append((trainer.state, scene))
        key = key or trainer
    assert key is not None
    scene = dataclasses.replace(trained[0][1], segments=tuple(scene.segments[0] for _, scene in trained))
    states = [state for state, _ in trained]
    summary = {
        "seconds": sum(state.seconds for state in states),
        "iterations": total,
        "lens_falloff": _mean_falloff(key.state),
        **key.figures(),
        "dynamic": float(sum(len(state.dynamic) for state in states)),
        "history": key.state.history.curves,
        "profile": _summed([state.history.profile for state in states]),
        "pruned": sum(state.history.pruned for state in states),
        "births": sum(state.history.births for state in states),
        "infilled": key.state.history.infilled,
        "labels_changed": _summed([state.history.labels_changed for state in states]),
    }
    return scene, summary


def _mean_falloff(state: TrainState) -> list[float] | None:
    correction = state.correction
    falloff = None if correction is None else correction.falloff
    return None if falloff is None else falloff.mean(0).tolist()


def _summed(tables: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {name: sum(table.get(name, 0) for table in tables) for name in dict.fromkeys(k for t in tables for k in t)}
