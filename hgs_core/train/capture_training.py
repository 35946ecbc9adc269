"""Training a whole capture: the first segment with the statics, then every other one against them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.backdrop import Backdrop
from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene.camera import Camera
from hgs_core.scene.files import save_scene_by_segment
from hgs_core.scene.motion import coefficients_of_order
from hgs_core.scene.splats import HybridScene
from hgs_core.train.checkpoint import TrainState, load_state
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.segment_cuts import CaptureSegment, cut_into_segments
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.trainer import Trainer
from hgs_core.train.training_preview import Preview

__all__ = ["TrainingInputs", "in_iterations", "save_trained", "segment_trainer", "train_capture"]


@dataclass(frozen=True)
class TrainingInputs:
    """The inputs of a capture's training, the same for all of its segments."""

    capture: Capture
    cameras: Mapping[int, Camera]  # training cameras by their index in the capture, with their near planes
    config: TrainConfig
    seed: int  # seed of all random draws
    points: Callable[[CaptureSegment], PointCloud]  # labelled first points that were seen in a segment
    sampled_every: int  # frames between the moments of dynamic points, at most
    masks: MotionMasks | None = None  # masks of the movers; needed where the config's stages are `separate`
    backdrop: Backdrop | None = None  # surface of the statics, where cameras stand far apart


def segment_trainer(
    inputs: TrainingInputs, segment: CaptureSegment, checkpoint: Path, after: TrainState | None
) -> Trainer:
    """Return the trainer of one segment of a capture; `checkpoint` and `after` are those of `Trainer`."""
    config = inputs.config if after is None else inputs.config.later
    start = initial_splats(
        inputs.points(segment),
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
        backdrop=inputs.backdrop,
        after=after,
    )


def train_capture(
    inputs: TrainingInputs,
    checkpoint: Callable[[int], Path],
    progress: ProgressCallback,
    preview: Path | None = None,
) -> dict[str, Any]:
    """Train all segments and return the summary that train.json keeps; `save_trained` writes the scene.

    The statics and the cameras' colour maps are those of the first segment; the others learn their dynamics alone, so
    that they depend on nothing but the first one's end. Besides that, one segment at a time is in memory.

    Args:
        inputs: capture, cameras, config and points.
        checkpoint: gives the file of a segment's state; that of a finished segment stays as it is.
        progress: called as if all segments were one training.
        preview: a JPEG file that shows how far the training is, from the first of these cameras; None: none is drawn.

    Raises:
        StageStopped: the callback asked to stop; the state was saved first.
    """
    config, cameras = inputs.config, inputs.cameras
    segments = cut_into_segments(inputs.capture.times, config.segment_frames)
    total = config.iterations * len(segments)
    drawn = None if preview is None else Preview(preview, next(iter(cameras.values())), config)

    def trained(number: int, after: TrainState | None) -> TrainState:
        file, before = checkpoint(number), number * config.iterations
        own = config if number == 0 else config.later
        if file.exists() and (state := load_state(file)).iteration == own.iterations:
            return state
        trainer = segment_trainer(inputs, segments[number], file, after)

        def report(step: Progress) -> None:
            whole = in_iterations(step, config)
            whole = dataclasses.replace(whole, done=before + whole.done, total=total)
            if drawn is not None:
                drawn.follow(trainer.state, whole)
            progress(whole)

        trainer.run(report)
        return trainer.state

    key = trained(0, None)
    figures = [_figures(key), *(_figures(trained(number, key)) for number in range(1, len(segments)))]
    return {
        "seconds": sum(one.seconds for one in figures),
        "iterations": config.iterations + (len(segments) - 1) * config.later.iterations,
        "lens_falloff": _mean_falloff(key),
        "colour_map": None if key.correction is None else key.correction.affine.quantile(0.5, dim=0).tolist(),
        "time_shifts": _time_shifts(key, inputs),
        **key.figures(),
        "dynamic": float(sum(one.dynamic for one in figures)),
        "history": key.history.curves,
        "profile": _summed([one.profile for one in figures]),
        "pruned": sum(one.pruned for one in figures),
        "births": sum(one.births for one in figures),
        "infilled": key.history.infilled,
        "labels_changed": _summed([one.labels_changed for one in figures]),
    }


def in_iterations(step: Progress, config: TrainConfig) -> Progress:
    """Return the progress of a segment in iterations of the first one."""
    return dataclasses.replace(step, done=step.done * config.iterations // step.total, total=config.iterations)


def save_trained(path: Path, inputs: TrainingInputs, checkpoint: Callable[[int], Path]) -> None:
    """Write the scene of trained segments (`hgs_core.scene.files`), read from their states one after the other.

    Raises:
        InputError: a state is damaged.
        FileNotFoundError: one is missing.
    """
    segments = cut_into_segments(inputs.capture.times, inputs.config.segment_frames)
    statics = load_state(checkpoint(0)).static.map(_as_array)
    scene = HybridScene(statics, tuple(one.clock for one in segments), antialiased=inputs.config.antialiased)
    states = (load_state(checkpoint(number)) for number in range(len(segments)))
    save_scene_by_segment(path, scene, (state.dynamic.map(_as_array) for state in states))


@dataclass(frozen=True)
class _SegmentFigures:
    """Figures of a segment for the summary."""

    seconds: float
    dynamic: int
    profile: dict[str, Any]
    labels_changed: dict[str, Any]
    pruned: int
    births: int


def _figures(state: TrainState) -> _SegmentFigures:
    history = state.history
    return _SegmentFigures(
        state.seconds, len(state.dynamic), history.profile, history.labels_changed, history.pruned, history.births
    )


def _as_array(tensor: Tensor) -> npt.NDArray[np.float32]:
    return np.asarray(tensor.numpy(), np.float32)


def _mean_falloff(state: TrainState) -> list[float] | None:
    correction = state.correction
    falloff = None if correction is None else correction.falloff
    return None if falloff is None else falloff.mean(0).tolist()


def _time_shifts(state: TrainState, inputs: TrainingInputs) -> dict[str, float] | None:
    """Return the seconds by which each training camera is late, by name."""
    if state.time_shifts is None:
        return None
    names = [inputs.capture.cameras[index].name for index in inputs.cameras]
    return dict(zip(names, state.time_shifts.seconds.tolist(), strict=True))


def _summed(tables: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {name: sum(table.get(name, 0) for table in tables) for name in dict.fromkeys(k for t in tables for k in t)}
